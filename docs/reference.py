"""Write docs/commands.md from the parser, docs/settings.md from the JSON schema, and the figures.

    uv run python docs/reference.py

The same code gives the same bytes; a test compares them.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from halo_service.app.parser import COMMANDS, make_parser
from halo_service.evaluation.report.figures import figures_page
from halo_service.settings.schema import schema_text

FOLDER = Path(__file__).parent
COMMAND = "`uv run python docs/reference.py`"


COMMON = ("--help", "--debug", "--config")


def commands() -> str:
    """Return the page of all commands, in the order of `halo --help`."""
    lines = [
        "# Commands",
        "",
        f"{COMMAND} writes this page from the help texts. Every command has",
        "`--help`; most also have `--config FILE` (settings, default: `halo.toml`) and `--debug`",
        "(print more, and show tracebacks).",
    ]
    verbs = _subcommands(make_parser())
    for name, command in COMMANDS.items():
        summary = command.SUMMARY
        lines += ["", f"## halo {name}", "", f"{summary[0].upper()}{summary[1:]}.", ""]
        lines += [f"    {command.EXAMPLE}", "", "| | |", "|---|---|", *_rows(verbs[name])]
    return "\n".join([*lines, ""])


def _rows(parser: argparse.ArgumentParser) -> Iterator[str]:
    """A row for each option, or for each sub-command with all its options."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            helps = {each.dest: each.help or "" for each in action._choices_actions}
            for name, verb in action.choices.items():
                spellings = " ".join([name, *map(_spelling, _options(verb))])
                yield f"| `{spellings}` | {_cell(helps.get(name, ''))} |"
    for action in _options(parser):
        words = (action.help or "") % {**vars(action), "prog": parser.prog}
        yield f"| `{_spelling(action)}` | {_cell(words)} |"


def _options(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    return [
        each
        for each in parser._actions
        if not isinstance(each, argparse._SubParsersAction)
        and not set(each.option_strings) & set(COMMON)
    ]


def _subcommands(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            return dict(action.choices)
    return {}


def _spelling(action: argparse.Action) -> str:
    value = action.metavar or action.dest.upper()
    if not action.option_strings:
        return f"[{value}]" if action.nargs in ("?", "*") else str(value)
    name = action.option_strings[-1]
    return name if action.nargs == 0 else f"{name} {value}"


def settings() -> str:
    """Return the page of all settings, in the order of the schema."""
    schema: dict[str, Any] = json.loads(schema_text())
    lines = [
        "# Settings",
        "",
        f"{COMMAND} writes this page from [halo.schema.json](halo.schema.json),",
        "which editors can use to check `halo.toml`.",
        "",
        "`halo` reads `halo.toml` in the current folder, or the file after `--config`. Options on",
        "the command line have priority. Write a Windows path in single quotes:",
        "`'recording:C:\\recordings\\new.mkv'`.",
        "",
        "```toml",
        'node = "stage"',
        "",
        "[source]",
        'name = "azure-kinect"',
        "",
        "[osc]",
        'destinations = ["127.0.0.1:4256", "192.168.1.20:4256"]',
        "```",
        "",
        "## At the top of the file",
        "",
    ]
    sections = {}
    plain = {}
    for name, setting in schema["properties"].items():
        if "$ref" in setting:
            sections[name] = schema["$defs"][setting["$ref"].rpartition("/")[2]]
        else:
            plain[name] = setting
    lines += _settings(plain)
    for name, section in sections.items():
        lines += ["", f"## [{name}]", "", *_settings(section["properties"])]
    return "\n".join([*lines, ""])


def _settings(properties: dict[str, Any]) -> Iterator[str]:
    yield "| key | default | |"
    yield "|---|---|---|"
    for name, setting in properties.items():
        default = f"`{json.dumps(setting['default'])}`" if "default" in setting else ""
        words = [setting.get("description", ""), _limits(setting)]
        yield f"| `{name}` | {_cell(default)} | {_cell(' '.join(filter(None, words)))} |"


def _limits(setting: dict[str, Any]) -> str:
    if "enum" in setting:
        return f"One of: {', '.join(map(str, setting['enum']))}."
    low, high = setting.get("minimum"), setting.get("maximum")
    if low is not None and high is not None:
        return f"From {low:g} to {high:g}."
    if "exclusiveMinimum" in setting:
        return f"More than {setting['exclusiveMinimum']:g}."
    return f"{low:g} or more." if low is not None else ""


def _cell(words: str) -> str:
    """A `|` would end the cell of the table."""
    return " ".join(words.split()).replace("|", "\\|")


PAGES = {"commands.md": commands, "settings.md": settings, "results/figures.md": figures_page}


def main() -> None:
    """Write all pages."""
    for name, page in PAGES.items():
        (FOLDER / name).write_text(page(), encoding="utf-8")
        sys.stdout.write(f"{FOLDER / name}\n")


if __name__ == "__main__":
    main()
