"""The Unity package is complete; its Unity-facing part compiles against hand-written signatures.

Unity itself is not here: `stubs/` has stand-ins, written by hand from its public documentation.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.clients.unity.conftest import PACKAGE, sources
from tests.clients.unity.metas import metas

Compile = Callable[..., Path]


def definition(*parts: str) -> dict[str, Any]:
    return dict(json.loads(PACKAGE.joinpath(*parts).read_text()))


def test_each_file_has_its_meta_file_with_its_guid() -> None:
    wanted = metas()
    found = {path: path.read_text() for path in PACKAGE.rglob("*.meta")}
    assert found == wanted, "run: python tests/clients/unity/metas.py"
    guids = [re.search(r"^guid: ([0-9a-f]{32})$", text, re.MULTILINE) for text in found.values()]
    assert len({guid[1] for guid in guids if guid}) == len(wanted)


def test_the_manifest_names_what_is_there() -> None:
    manifest = definition("package.json")
    assert manifest["name"] == PACKAGE.name
    for sample in manifest["samples"]:
        folder = PACKAGE / sample["path"]
        assert (folder / "README.md").is_file()
        assert list(folder.glob("*.cs"))
    assert {each["path"] for each in manifest["samples"]} == {
        f"Samples~/{folder.name}" for folder in (PACKAGE / "Samples~").iterdir()
    }
    assert f"## [{manifest['version']}]" in (PACKAGE / "CHANGELOG.md").read_text()
    assert (PACKAGE / "LICENSE.md").read_text() == (PACKAGE.parents[2] / "LICENSE").read_text()


def test_files_are_short() -> None:
    lengths = {path: len(path.read_text().splitlines()) for path in sources()}
    assert max(lengths.values()) <= 300


def test_the_core_refers_to_no_type_of_unity() -> None:
    assert definition("Runtime", "Internal", "HaloTouch.Internal.asmdef")["noEngineReferences"]


def test_the_input_system_is_optional() -> None:
    optional = definition("Runtime", "InputSystem", "HaloTouch.InputSystem.asmdef")
    (version,) = optional["versionDefines"]
    assert version["name"] == "com.unity.inputsystem"
    assert optional["defineConstraints"] == [version["define"]]


def test_the_unity_facing_part_compiles(compile_csharp: Compile, core: Path, unity: Path) -> None:
    """Each assembly sees only those that its definition names; public members are documented."""
    built = {"HaloTouch.Internal": core, "Unity.InputSystem": unity}
    folders = {
        "HaloTouch": ("Runtime", [PACKAGE / "Runtime"]),
        "HaloTouch.InputSystem": ("Runtime/InputSystem", [PACKAGE / "Runtime" / "InputSystem"]),
        "HaloTouch.Editor": ("Editor", [PACKAGE / "Editor"]),
    }
    for name, (folder, places) in folders.items():
        named = definition(folder, f"{name}.asmdef")["references"]
        files = [file for place in places for file in sorted(place.glob("*.cs"))]
        references = [built[each] for each in named]
        built[name] = compile_csharp(f"{name}.dll", files, [*references, unity])
    compile_csharp("Samples.dll", sources("Samples~"), built.values())


def test_the_core_compiles_for_web_pages(compile_csharp: Compile) -> None:
    files = sources("Runtime", "Internal")
    compile_csharp("WebGl.dll", files, (), "-define:UNITY_WEBGL")
