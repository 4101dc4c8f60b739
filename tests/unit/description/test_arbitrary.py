"""Whatever stands in the file: a description, or faults that are sentences with a place; no traceback."""

from __future__ import annotations

import json
import re

from hypothesis import example, given, settings
from hypothesis import strategies as st

from end_effector_hal.description import Description, examine_text, profile_path
from end_effector_hal.description.reading._yaml import _decode
from tests.support.nightly import examples

SHIPPED = profile_path().read_text(encoding="utf-8")
LINES = SHIPPED.splitlines(keepends=True)
# what is special in YAML, and what a description is made of
PIECES = [
    *" \t\n:-?[]{}&*!|>'\"%@`#,~<.",
    "\r\n",
    ": ",
    "- ",
    "---\n",
    "<<",
    "5",
    "5 s",
    "1e9",
    "null",
    "kind",
    "&a ",
    "*a",
]
pieces = st.one_of(st.sampled_from(PIECES), st.characters(), st.sampled_from(SHIPPED.split()))
FORM = re.compile(r"tool\.yaml(:\d+:\d+)?: [^\n]+ \[EE-2\d\d\]")


def check(text: str) -> None:
    examination = examine_text(text, "tool.yaml")
    lines = examination.lines()
    assert (examination.description is None) == bool(lines)
    assert all(FORM.fullmatch(line) for line in lines), lines
    assert lines == [str(fault.diagnostic("tool.yaml")) for fault in sorted(examination.faults)]
    "\n".join(lines).encode()
    rows = text.split("\n")
    for fault in examination.faults:
        assert fault.line <= len(rows)
        assert fault.line == 0 or 1 <= fault.column <= len(rows[fault.line - 1]) + 1
    if examination.description:
        assert isinstance(examination.description, Description)


@given(st.text())
@settings(max_examples=examples(37, 3000), deadline=None)
def test_arbitrary_text(text: str) -> None:
    check(text)


@given(st.lists(pieces, max_size=40).map("".join))
@settings(max_examples=examples(37, 3000), deadline=None)
def test_arbitrary_pieces_of_yaml(text: str) -> None:
    check(text)


@given(st.integers(0, len(SHIPPED)))
@settings(max_examples=examples(20, 1500), deadline=None)
def test_a_truncated_description(end: int) -> None:
    check(SHIPPED[:end])


@given(st.lists(st.tuples(st.integers(0, len(SHIPPED)), st.integers(0, 12), pieces), min_size=1, max_size=4))
@settings(max_examples=examples(37, 3000), deadline=None)
def test_a_damaged_description(damages: list[tuple[int, int, str]]) -> None:
    text = SHIPPED
    for start, length, piece in damages:
        text = text[:start] + piece + text[start + length :]
    check(text)


@given(st.permutations(range(len(LINES))), st.integers(2, len(LINES)))
@settings(max_examples=examples(20, 1000), deadline=None)
def test_lines_out_of_order(order: list[int], count: int) -> None:
    check("".join(LINES[index] for index in order[:count]))


KEYS = sorted(
    {*re.findall(r"\w+(?=:)", SHIPPED), "[key]", "vacuum", "IL-09", "automata", "file", "release_order"}
)
WORDS = ["5 s", "[key]", "release", "virtual", "vacuum", "bottom"]
scalars = (
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.sampled_from(WORDS)
)
keys = st.text(max_size=5) | st.sampled_from(KEYS)
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(st.sampled_from(KEYS), values, max_size=8))
@example({"actuators": {"[key]": None}})
@example({"actuators": {"\n": None}, "name": "\ud800", "\ud800": 1})
@settings(max_examples=examples(37, 3000), deadline=None)
def test_good_yaml_with_any_value_anywhere(tree: dict[str, object]) -> None:
    # JSON is YAML; NaN and Infinity are words there
    check(json.dumps(tree, ensure_ascii=True))


@given(st.binary())
def test_arbitrary_bytes(data: bytes) -> None:
    text = _decode(data)
    if isinstance(text, str):
        check(text)
    else:
        assert FORM.fullmatch(str(text.diagnostic("tool.yaml")))
