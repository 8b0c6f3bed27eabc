"""The recipes of docs/networks.md, as machines run them.

A block of code names its machine: "```sh router" are commands of the router, "```toml table
halo.toml" is a file of the table.
"""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass, field
from pathlib import Path

from tests.networks.lab import Lab, Program

PAGE = Path(__file__).parents[2] / "docs" / "networks.md"
_BLOCK = re.compile(r"^```\w+ (\w+)(?: (\S+))?\n(.*?)^```", re.MULTILINE | re.DOTALL)
_SECTION = re.compile(r"^#+ (.*)$", re.MULTILINE)
WITHOUT_CAMERA = {"serve": "test-pattern"}


@dataclass
class Recipe:
    """Files and commands of some sections; of two files with one name the later one counts."""

    files: dict[tuple[str, str], str] = field(default_factory=dict)
    commands: dict[str, list[list[str]]] = field(default_factory=dict)

    def write(self, lab: Lab) -> None:
        """Write the files to the folders of their machines."""
        for (machine, name), text in self.files.items():
            (lab.machines[machine].folder / name).write_text(text)

    def start(self, lab: Lab, machine: str, number: int = 0, *further: str) -> Program:
        """Start a command, with further options. The test pattern replaces a camera."""
        words = [WITHOUT_CAMERA.get(each, each) for each in self.commands[machine][number]]
        return lab.machines[machine].start(*words, *further)


def recipe(*sections: str) -> Recipe:
    """Read sections of the page, by their headings."""
    parts = _sections(PAGE.read_text())
    found = Recipe()
    for section in sections:
        for machine, name, text in _BLOCK.findall(parts[section]):
            if name:
                found.files[machine, name] = text
            else:
                words = [shlex.split(line) for line in text.splitlines()]
                found.commands.setdefault(machine, []).extend(words)
    return found


def _sections(page: str) -> dict[str, str]:
    """The text below each heading, until the next one. Comments in code are no headings."""
    outside = re.sub(r"^```.*?^```", lambda block: block[0].replace("\n#", "\n "), page,
                     flags=re.MULTILINE | re.DOTALL)  # fmt: skip
    heads = list(_SECTION.finditer(outside))
    ends = [*(head.start() for head in heads[1:]), len(page)]
    return {head[1]: page[head.end() : end] for head, end in zip(heads, ends, strict=True)}
