"""The JSON Schema of a description, for editors."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic.json_schema import GenerateJsonSchema

from ._model import Description
from ._paths import profile_path


class _Untitled(GenerateJsonSchema):
    """Without a title for each key, which would only repeat the key."""

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False


def schema() -> dict[str, Any]:
    """JSON Schema, draft 2020-12, with meanings and defaults; rules between stanzas are not in it."""
    found = Description.model_json_schema(by_alias=True, schema_generator=_Untitled)
    actuators = found["properties"]["actuators"]
    actuators["additionalProperties"] = False
    for each in actuators["patternProperties"].values():
        # A word of OpenAPI's that JSON Schema does not know; oneOf says the same.
        each.pop("discriminator")
    return {"$schema": GenerateJsonSchema.schema_dialect, **found, "title": "End-effector description"}


def schema_text() -> str:
    """The same as a file, as it is shipped beside the profile."""
    return json.dumps(schema(), indent=2, ensure_ascii=False) + "\n"


def schema_path() -> Path:
    """The copy that is shipped beside the profile; the profile's first line names it."""
    return profile_path().with_name("end_effector.schema.json")
