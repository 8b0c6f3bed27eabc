"""Compiles the Unity client's core and its test program, once per run."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[3] / "clients" / "unity" / "com.halotouch.client"
PROGRAM = Path(__file__).with_name("program")
STUBS = Path(__file__).with_name("stubs")
LANGUAGE = "-langversion:7.2"
"""mcs has no later C#; Unity 2022 accepts 9."""


@pytest.fixture(scope="session")
def compile_csharp(
    external_program: Callable[[str], str], tmp_path_factory: pytest.TempPathFactory
) -> Callable[..., Path]:
    """`compile_csharp(name, files, references, *options)` -> the library or program.

    Warnings are errors, such as a public member without a comment.
    """
    mcs = external_program("mcs")
    external_program("mono")
    folder = tmp_path_factory.mktemp("csharp")

    def build(
        name: str, files: Sequence[Path], references: Sequence[Path] = (), *options: str
    ) -> Path:
        built = folder / name
        kind = "exe" if name.endswith(".exe") else "library"
        done = subprocess.run(
            [
                mcs, LANGUAGE, "-warn:4", "-warnaserror", f"-target:{kind}",
                f"-out:{built}", f"-doc:{built}.xml", *(f"-r:{each}" for each in references),
                *options, *map(str, files),
            ],
            capture_output=True,
            text=True,
            timeout=120,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return built

    return build


def sources(*parts: str) -> list[Path]:
    """The C# files of a folder of the package."""
    return sorted(PACKAGE.joinpath(*parts).rglob("*.cs"))


@pytest.fixture(scope="session")
def core(compile_csharp: Callable[..., Path]) -> Path:
    """The library without a type of Unity: it has no reference to it."""
    return compile_csharp("HaloTouch.Internal.dll", sources("Runtime", "Internal"))


@pytest.fixture(scope="session")
def program(compile_csharp: Callable[..., Path], core: Path) -> list[str]:
    """The command of the test program."""
    built = compile_csharp("HaloTouch.Tests.exe", sorted(PROGRAM.glob("*.cs")), [core])
    return ["mono", str(built)]


@pytest.fixture(scope="session")
def run_csharp(program: list[str]) -> Callable[..., list[str]]:
    """`run_csharp(lines, mode, *arguments)` -> the lines that the program writes."""

    def run(lines: Sequence[str], *arguments: str) -> list[str]:
        done = subprocess.run(
            [*program, *arguments],
            input="".join(f"{line}\n" for line in lines),
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines()

    return run


@pytest.fixture(scope="session")
def unity(compile_csharp: Callable[..., Path]) -> Path:
    """Stand-ins for Unity, written by hand from its public documentation."""
    return compile_csharp("Unity.dll", sorted(STUBS.glob("*.cs")), (), "-nowarn:0649,1591")
