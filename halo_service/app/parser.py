"""The command line of `halo`: one sub-command a module of `commands`, and errors that help.

Rule: nothing heavy is imported to read the command line or to print a help text.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib.metadata import version
from typing import Any, NoReturn, Protocol

import halo_protocol as wire
from halo_service.app.commands import (
    bench,
    bridge,
    calibrate,
    cameras,
    canvas,
    conformance,
    demo,
    doctor,
    evaluate,
    first_light,
    import_dataset,
    install_service,
    list_services,
    monitor,
    profile,
    record,
    replay,
    router,
    serve,
    simulate,
    targets,
    test_pattern,
    verify,
)
from halo_service.errors import suggestion


class Command(Protocol):
    """What a module of `commands` has."""

    SUMMARY: str
    """What the command is for, in one line that goes on after its name."""
    EXAMPLE: str

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Add the options of the command."""

    def run(self, options: argparse.Namespace) -> int:
        """Run the command; return its exit code. Raises `UserError`."""


COMMANDS: dict[str, Command] = {
    "serve": serve,
    "monitor": monitor,
    "demo": demo,
    "list": list_services,
    "doctor": doctor,
    "cameras": cameras,
    "calibrate": calibrate,
    "verify": verify,
    "first-light": first_light,
    "profile": profile,
    "targets": targets,
    "record": record,
    "replay": replay,
    "test-pattern": test_pattern,
    "bridge": bridge,
    "canvas": canvas,
    "router": router,
    "simulate": simulate,
    "evaluate": evaluate,
    "bench": bench,
    "import-dataset": import_dataset,
    "install-service": install_service,
    "conformance": conformance,
}
"""In the order of the help text: what most users need first."""

FIRST_STEPS = """\
first steps:
  halo serve                          start with a camera, or with the virtual one
  halo monitor                        show what a running service sends
  halo calibrate --profile desk       calibrate your table and your finger
  halo serve --profile desk           start with that calibration

'halo COMMAND --help' shows the options of a command and an example.
"""


class Parser(argparse.ArgumentParser):
    """An `ArgumentParser`. Its errors are one sentence and name the nearest known word."""

    def __init__(self, **keywords: Any) -> None:
        """`keywords`: as for `ArgumentParser`; options cannot be abbreviated."""
        super().__init__(
            **keywords,
            allow_abbrev=False,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse; report an unknown option first, before any missing one."""
        if self.get_default("forwards_options"):
            return super().parse_known_args(args, namespace)
        self._check_options(args)
        options, rest = super().parse_known_args(args, namespace)
        if rest and not self._subparsers:
            self.error(f"unexpected argument '{rest[0]}'")
        return options, rest

    def _check_options(self, arguments: Sequence[str]) -> None:
        known = self._option_string_actions
        for argument in arguments:
            if argument == "--" or (self._subparsers and not argument.startswith("-")):
                return  # what follows a command belongs to that command
            name = argument.partition("=")[0]
            if name.startswith("--") and name not in known:
                near = suggestion(name, known)
                self.error(f"unknown option '{name}'" + (f"; {near}" if near else ""))

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        names = [str(each) for each in action.choices]
        what = action.option_strings[0] if action.option_strings else str(action.metavar).lower()
        hint = suggestion(str(value), names) or f"choose from: {', '.join(names)}"
        self.error(f"unknown {what} '{value}'; {hint}")

    def error(self, message: str) -> NoReturn:
        """Print one sentence and leave with exit code 2."""
        self.exit(2, f"{self.prog}: {message}\n(see '{self.prog} --help')\n")


def make_parser() -> Parser:
    """Make the parser. Its result holds the function of the command as `run`."""
    halo = Parser(
        prog="halo",
        usage="halo [-h] [--version] COMMAND ...",
        description="A depth camera above a table makes it a touch surface.",
        epilog=_epilog(),
    )
    halo.add_argument(
        "--version",
        action="version",
        version=f"halo-service {version('halo-service')}, protocol {wire.VERSION}",
    )
    halo.set_defaults(debug=False, forwards_options=False, rest=())
    commands = halo.add_subparsers(
        prog="halo", dest="verb", metavar="COMMAND", help=argparse.SUPPRESS
    )
    for name, command in COMMANDS.items():
        summary = command.SUMMARY
        verb = commands.add_parser(
            name,
            description=f"{summary[0].upper()}{summary[1:]}.",
            epilog=f"example:\n  {command.EXAMPLE}",
            add_help=command is not demo,  # its help is also that of a client
        )
        verb.set_defaults(run=command.run)
        command.add_arguments(verb)
    return halo


def _epilog() -> str:
    commands = [f"  {name:16}{command.SUMMARY}" for name, command in COMMANDS.items()]
    return "\n".join(["commands:", *commands, "", FIRST_STEPS])


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Parse a command line; exits with code 2 where it is wrong, with 0 after a help text.

    `rest` of the result: options that the command forwards to another program.
    """
    halo = make_parser()
    if not arguments:
        halo.exit(2, halo.format_help())
    options: argparse.Namespace
    options, rest = halo.parse_known_args(arguments)
    options.rest = rest
    return options
