"""What is generated from the model and committed: the schema beside the profile, the tables of the docs.

``EEHAL_UPDATE=1 pytest tests/unit/description/test_documents.py`` writes both anew.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

import pytest

import end_effector_hal
from end_effector_hal.description import (
    examine_text,
    markdown,
    profile_path,
    schema,
    schema_path,
    schema_text,
)
from end_effector_hal.description._reference import BEGIN
from end_effector_hal.description._shape import fields_of, stanzas
from tests.support.places import DOCS

DOCUMENT = DOCS / "reference/description.md"
KEYS = DOCS / "reference/keys.md"
UPDATE = bool(os.environ.get("EEHAL_UPDATE"))


def test_the_committed_schema_is_that_of_the_model() -> None:
    if UPDATE:
        schema_path().write_text(schema_text(), encoding="utf-8")
    assert schema_path().read_text(encoding="utf-8") == schema_text(), "see the head of this file"


def test_the_documented_keys_are_those_of_the_model() -> None:
    text = KEYS.read_text(encoding="utf-8")
    written = text.partition(BEGIN)[0] + markdown()
    if UPDATE:
        KEYS.write_text(written, encoding="utf-8")
    assert KEYS.read_text(encoding="utf-8") == written, "see the head of this file"


def test_the_smallest_description_of_the_document_is_valid() -> None:
    text = DOCUMENT.read_text(encoding="utf-8").split("```yaml\n")[1].split("```")[0]
    assert examine_text(text, "tool.yaml").lines() == []


def test_the_profile_names_the_schema_for_editors() -> None:
    first = profile_path().read_text(encoding="utf-8").splitlines()[0]
    assert first == f"# yaml-language-server: $schema={schema_path().name}"
    assert schema_path().parent == profile_path().parent


def test_the_schema_is_of_draft_2020_12_and_refuses_unknown_keys_everywhere() -> None:
    found = schema()
    assert found["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    objects = [found, *found["$defs"].values()]
    assert all(each["additionalProperties"] is False for each in objects)
    assert found["required"] == ["name", "sequence", "actuators"]


def _references(node: Any) -> list[str]:
    if isinstance(node, dict):
        own = [node["$ref"]] if "$ref" in node else []
        return own + [each for value in node.values() for each in _references(value)]
    return [each for value in node for each in _references(value)] if isinstance(node, list) else []


def test_every_reference_of_the_schema_is_defined() -> None:
    found = json.loads(schema_text())
    assert {each.removeprefix("#/$defs/") for each in _references(found)} == set(found["$defs"])


@pytest.mark.parametrize("path", stanzas())
def test_every_key_has_a_meaning(path: str) -> None:
    assert [key for key, field in fields_of(stanzas()[path]).items() if not field.description] == []


def test_every_code_of_the_source_is_documented() -> None:
    source = Path(end_effector_hal.__file__).parents[1]
    texts = [path.read_text(encoding="utf-8") for path in source.rglob("*.py")]
    codes = {code for text in texts for code in re.findall(r"EE-\d{3}", text)}
    page = (DOCS / "reference/errors.md").read_text(encoding="utf-8")
    assert len(codes) > 25
    assert codes == set(re.findall(r"^### (EE-\d{3})", page, re.MULTILINE))
