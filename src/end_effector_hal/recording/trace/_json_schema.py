"""JSON schemas as plain as the viewers of MCAP files want them: no references, no alternatives with null."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import TypeAdapter


def plain_schema(kind: type) -> dict[str, Any]:
    """The schema of a dataclass."""
    schema = TypeAdapter(kind).json_schema()
    found = _plain(schema, schema.get("$defs", {}))
    assert isinstance(found, dict)
    return found


def _plain(schema: Any, known: Mapping[str, Any]) -> Any:
    if isinstance(schema, list):
        return [_plain(item, known) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if "$ref" in schema:
        return _plain(known[schema["$ref"].rpartition("/")[2]], known)
    if "anyOf" in schema:
        first, *_ = [option for option in schema["anyOf"] if option.get("type") != "null"]
        return _plain(first, known)
    left_out = ("$defs", "default", "prefixItems", "minItems", "maxItems")
    return {key: _plain(value, known) for key, value in schema.items() if key not in left_out}
