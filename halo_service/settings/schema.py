"""The JSON schema of `halo.toml`, for editors.

`python -m halo_service.settings.schema` writes it to `docs/halo.schema.json`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic.json_schema import GenerateJsonSchema

from halo_service.settings.file import ADAPTER

FILE = Path(__file__).parents[2] / "docs" / "halo.schema.json"
UNITS = {"_mm_s": "mm/s", "_per_s": "1/s", "_mm": "mm", "_ms": "ms"}
"""Units by the end of a setting's name, the longest end first."""


class _Untitled(GenerateJsonSchema):
    def field_title_should_be_set(self, schema: Any) -> bool:
        return False


def schema_text() -> str:
    """Return the schema as it is written to `docs/halo.schema.json`."""
    schema = ADAPTER.json_schema(schema_generator=_Untitled)
    for table in (schema, *schema["$defs"].values()):
        for name, setting in table["properties"].items():
            if "description" in setting:
                setting["description"] = " ".join(setting["description"].split())
            unit = next((unit for end, unit in UNITS.items() if name.endswith(end)), None)
            if unit is not None:
                setting["unit"] = unit
    return json.dumps(schema, indent=2) + "\n"


if __name__ == "__main__":
    FILE.write_text(schema_text(), encoding="utf-8")
