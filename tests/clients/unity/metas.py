"""Writes the .meta files of the Unity package: `python tests/clients/unity/metas.py`.

Unity refuses files of a package without them, and finds files by their GUID. A GUID is computed
from the path, so it is the same in each copy. Folders that end with ~ have none.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

PACKAGE = Path(__file__).parents[3] / "clients" / "unity" / "com.halotouch.client"
END = "  userData: \n  assetBundleName: \n  assetBundleVariant: \n"
PLAIN = "  externalObjects: {}\n"
SCRIPT = (
    "  externalObjects: {}\n  serializedVersion: 2\n  defaultReferences: []\n"
    "  executionOrder: 0\n  icon: {instanceID: 0}\n"
)
WEBGL_ONLY = """\
  externalObjects: {}
  serializedVersion: 2
  iconMap: {}
  executionOrder: {}
  defineConstraints: []
  isPreloaded: 0
  isOverridable: 0
  isExplicitlyReferenced: 0
  validateReferences: 1
  platformData:
  - first:
      Any:
    second:
      enabled: 0
      settings: {}
  - first:
      Editor: Editor
    second:
      enabled: 0
      settings:
        DefaultValueInitialized: true
  - first:
      WebGL: WebGL
    second:
      enabled: 1
      settings: {}
"""
IMPORTERS = {
    ".cs": ("MonoImporter", SCRIPT),
    ".asmdef": ("AssemblyDefinitionImporter", PLAIN),
    ".md": ("TextScriptImporter", PLAIN),
    ".json": ("PackageManifestImporter", PLAIN),
    ".jslib": ("PluginImporter", WEBGL_ONLY),
}


def metas() -> dict[Path, str]:
    """Path -> text of each .meta file that the package needs."""
    return {path.with_name(f"{path.name}.meta"): meta(path) for path in _assets(PACKAGE)}


def _assets(folder: Path) -> list[Path]:
    found = []
    for path in sorted(folder.iterdir()):
        if path.name.startswith(".") or path.name.endswith("~") or path.suffix == ".meta":
            continue
        found += [path, *(_assets(path) if path.is_dir() else [])]
    return found


def meta(path: Path) -> str:
    """The text of the .meta file of a file or folder."""
    name = f"{PACKAGE.name}/{path.relative_to(PACKAGE).as_posix()}"
    guid = hashlib.md5(name.encode(), usedforsecurity=False).hexdigest()
    head = f"fileFormatVersion: 2\nguid: {guid}\n"
    if path.is_dir():
        return f"{head}folderAsset: yes\nDefaultImporter:\n{PLAIN}{END}"
    importer, settings = IMPORTERS[path.suffix]
    return f"{head}{importer}:\n{settings}{END}"


def main() -> None:
    """Write what is missing or wrong, and remove what belongs to no file."""
    wanted = metas()
    for path in PACKAGE.rglob("*.meta"):
        if path not in wanted:
            path.unlink()
    for path, text in wanted.items():
        path.write_text(text)


if __name__ == "__main__":
    main()
