"""Text that is not YAML, or YAML that a description does not use; whatever stands in a file, no traceback."""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from end_effector_hal.description import Description, examine_text, load, profile_path
from end_effector_hal.description.reading import _yaml
from end_effector_hal.description.reading._yaml import (
    DEPTH,
    NODES,
    CountingComposer,
    LineStarts,
    _decode,
    position,
)
from end_effector_hal.errors import DescriptionError
from tests.support.nightly import examples, first_of

# ruff: noqa: E501


BOMB = "".join(
    f"{key}: &{key} [{', '.join([each] * 10)}]\n"
    for key, each in zip("abcde", ["x", "*a", "*b", "*c", "*d"], strict=True)
)
EMPTY = "tool.yaml: the file is empty, expected a description; eehal schema lists its keys [EE-201]"

SYNTAX = {
    "a tab": ("name: tool\nlink:\n\tport: x\n", "3:1: not YAML: a tab (port: x), expected spaces to indent [EE-202]"),
    "two colons": ("name: a: b\n", "1:8: not YAML: a ':' too many (name: a: b), expected quotes around a text with ': ' in it [EE-202]"),
    "no colon": ("name: tool\nlink\nsequence: [a]\n", "2:1: not YAML: a line without ':' (link), expected key: value [EE-202]"),
    "indentation": ("link:\n  port: x\n baudrate: 5\n", "3:2: not YAML: the indentation fits no line above (baudrate: 5), expected the keys of a stanza in one column [EE-202]"),
    "quote": ("name: 'tool\nlink: 5\n", "1:7: not YAML: a quote is not closed (name: 'tool), expected the closing quote [EE-202]"),
    "cut in a quote": ('link:\n  port: "/dev', '2:9: not YAML: a quote is not closed (port: "/dev), expected the closing quote [EE-202]'),
    "bracket": ("sequence: [cup, rod\nname: x\n", "1:11: not YAML: a bracket is not closed, or a comma is missing (sequence: [cup, rod), expected [a, b, c] [EE-202]"),
    "brace": ("link: {port: x\nname: y\n", "1:7: not YAML: a brace is not closed, or a comma is missing (link: {port: x), expected {key: value, …} [EE-202]"),
    "cut in a brace": ("name: tool\nlink: {", "2:8: not YAML: the file ends too early (link: {), expected the rest of it [EE-202]"),
    "alias": ("name: *no\n", "1:7: not YAML: an alias that no anchor defines (name: *no), expected an &anchor above it [EE-202]"),
    "documents": ("name: a\n---\nname: b\n", "2:1: not YAML: a second document (---), expected one; '---' stands at the top only [EE-202]"),
    "percent": ("name: %x\n", "1:7: not YAML: a text begins with '%' (name: %x), expected quotes around it [EE-202]"),
    "at": ("name: @x\n", "1:7: not YAML: a text begins with a reserved character (name: @x), expected quotes around it [EE-202]"),
    "escape": ('name: "a\\q"\n', '1:10: not YAML: an unknown escape in a quoted text (name: "a\\q"), expected single quotes [EE-202]'),
    "control": ("name: a\x07b\n", "1:8: not YAML: a character that cannot be printed (U+0007), expected text [EE-202]"),
    "deep": ("[" * 30, f"1:21: not YAML: nested too deep ({'[' * 30}), expected a few levels [EE-202]"),
    "a list": ("- a\n- b\n", "1:1: this is not a description (- a…), expected keys with values [EE-203]"),
    "a word": ("hello", "1:1: this is not a description (hello), expected keys with values [EE-203]"),
}  # fmt: skip

UNUSED = {
    "a tag": ({"L1": "name: !thing tool"}, "1:7: tags mean nothing here (!thing tool), expected a plain value [EE-203]"),
    "python": ({"L1": "name: !!python/object/apply:os.system [ls]"}, "1:7: tags mean nothing here (!!python/object/apply:os.system [ls]), expected a plain value [EE-203]"),
    "a tagged stanza": ({"L2": "link: !a"}, "2:7: tags mean nothing here (!a…), expected a plain value [EE-203]"),
    "version": ({"L1": "%YAML 1.1\n---\nname: tool"}, "1:1: another version of YAML (%YAML 1.1), expected %YAML 1.2 [EE-203]"),
    "merge": ({"L6": "  cup: &cup", "L13": "    channel: cylinder\n    <<: *cup"}, "14:5: merge keys are not part of YAML 1.2 (<<), expected the keys themselves [EE-203]"),
    "key": ({"L3": "  port: x\n  ? [a]\n  : b"}, "4:5: a key is not a word ([a]), expected key: value [EE-203]"),
    "alias in itself": ({"L1": "name: tool\nsummary: &a [*a]"}, "2:10: an alias is inside of what it names (&a [*a]), expected a copy of the stanza [EE-203]"),
}  # fmt: skip


@pytest.mark.parametrize("name", SYNTAX)
def test_text_that_is_no_description(faults: Callable[..., list[str]], name: str) -> None:
    text, expected = SYNTAX[name]
    assert faults(text) == [f"tool.yaml:{expected}"]


@pytest.mark.parametrize("name", UNUSED)
def test_yaml_that_is_not_used_is_one_fault_among_the_others(
    faults: Callable[..., list[str]], name: str
) -> None:
    changes, expected = UNUSED[name]
    assert f"tool.yaml:{expected}" in faults(**changes)


@pytest.mark.parametrize("text", ["", "# nothing\n", "~", "---\n", "\ufeff"])
def test_an_empty_file(faults: Callable[..., list[str]], text: str) -> None:
    assert faults(text) == [EMPTY]


def test_aliases_that_unfold_without_end_are_refused_quickly(faults: Callable[..., list[str]]) -> None:
    found = [line for line in faults(BOMB) if "EE-203" in line]
    assert found == [
        "tool.yaml:1:35: the aliases unfold to too much (x), expected at most 10000 values [EE-203]"
    ]


@pytest.mark.parametrize(
    "changes",
    [
        {"L9": "    channel: bottom\n    timeout_s: &t 4", "L13": "    channel: cylinder\n    timeout_s: *t"},
        {"L3": "  port: x\n  baudrate: 0x2580"},
        {"L1": "\"name\": 'tool'"},
        {"L1": "%YAML 1.2\n---\nname: tool"},
        {"L1": "name: !!str tool"},
        {"L8": "    line: !!str 208"},
        {"L8": "    line: off"},
        {"L8": "    line: 2020-01-01"},
        {"L4": "sequence:\n- cup\n- rod"},
        {"L14": "tool_changer: ~", "L15": ""},
    ],
)
def test_yaml_that_is_good(faults: Callable[..., list[str]], changes: dict[str, str]) -> None:
    assert faults(**changes) == []


def test_words_of_yaml_1_1_are_text(changed: Callable[..., str]) -> None:
    description = examine_text(changed(L8="    line: off", L12="    line: 1_0"), "tool.yaml").description
    assert [actuator.line for _, actuator in description.ordered] == ["off", "1_0"]


@pytest.mark.parametrize(
    "form", [lambda text: text.replace("\n", "\r\n"), lambda text: "\ufeff" + text, str.rstrip]
)
def test_line_ends_and_byte_order_marks_do_not_matter(
    faults: Callable[..., list[str]], changed: Callable[..., str], form: Callable[[str], str]
) -> None:
    text = form(changed())
    assert faults(text) == []
    assert faults(text.replace("/dev/ttyS0", "5"))[0].startswith("tool.yaml:3:9: ")


def test_bytes_that_are_not_text(faults: Callable[..., list[str]]) -> None:
    broken = ["tool.yaml:2:9: this is not text (byte 0xFF), expected YAML in UTF-8 [EE-201]"]
    assert faults(b"name: tool\nsummary:\xff") == broken
    assert faults(b"\x7fELF\x02\x01\x01\x00")[0].startswith(
        "tool.yaml:1:1: not YAML: a character that cannot be printed (U+007F)"
    )
    assert (
        faults("name: tool\n".encode("utf-16"))[0]
        == "tool.yaml:1:1: this is not text (byte 0xFF), expected YAML in UTF-8 [EE-201]"
    )


def refusal(path: str | Path) -> str:
    with pytest.raises(DescriptionError) as caught:
        load(path)
    assert len(caught.value.faults) == 1
    assert caught.value.exit_code == 2
    return caught.value.faults[0]


def test_files_that_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("tool.yaml").touch()
    Path("folder").mkdir()
    Path("large.yaml").write_bytes(b"#" * 300_000)
    assert (
        refusal("toool.yaml")
        == "toool.yaml: there is no such file, expected the path of a description; did you mean 'tool.yaml'? [EE-201]"
    )
    assert (
        refusal("nowhere/x.yaml")
        == "nowhere/x.yaml: there is no such file, expected the path of a description [EE-201]"
    )
    assert refusal("folder") == "folder: this is a directory, expected the path of a description [EE-201]"
    os.mkfifo("pipe")
    assert (
        refusal("pipe")
        == "pipe: this is a named pipe, not a file, expected the path of a description [EE-201]"
    )
    assert (
        refusal("tool.yaml/x")
        == "tool.yaml/x: the file cannot be read: Not a directory, expected the path of a description [EE-201]"
    )
    assert (
        refusal("large.yaml")
        == "large.yaml: the file is too large, expected a description of at most 256 KiB [EE-201]"
    )
    assert "cannot be read" in refusal("a\0b")
    (tmp_path / "folder" / "end_effector.yaml").touch()
    assert refusal("folder").endswith("; write folder/end_effector.yaml [EE-201]")


def test_a_file_without_permission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, os.strerror(13))

    # root reads everything, so the refusal is played
    monkeypatch.setattr(Path, "open", refuse)
    assert refusal(tmp_path / "x.yaml").endswith(
        "x.yaml: the file may not be read, expected read permission for this user [EE-201]"
    )


def big(text: str, size: int = 240_000) -> str:
    """So much of the same."""
    return text * (size // len(text))


# Each of 240 KB, or unfolding to as much
MUCH = {
    "keys": "".join(f"k{number}: 1\n" for number in range(20_000)),
    "elements": "sequence:\n" + big("- a\n"),
    "flow": f"sequence: [{big('a,')}a]\n",
    "aliases": f"a: &x [1, 2]\nb: [{big('*x,')}*x]\n",
    "anchors": "".join(f"a{number}: &x{number} 1\n" for number in range(16_000)),
    "actuators": "actuators:\n" + "".join(f"  a{n}: {{kind: vacum, line: x}}\n" for n in range(8_000)),
    "the same key": big("a: 1\n"),
}


@pytest.mark.parametrize("much", first_of(MUCH, 4))
def test_a_file_with_too_many_values_is_refused_before_it_is_read(
    much: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    work = counted(monkeypatch)
    (fault,) = examine_text(MUCH[much], "tool.yaml").faults
    assert (fault.code, fault.what, fault.expected) == (
        "EE-203",
        "the file holds too much",
        f"at most {NODES} values",
    )
    line, column = MUCH[much][:240_000].count("\n"), fault.column
    assert 1 <= fault.line <= line + 1
    assert column >= 1
    assert work == {"values": NODES + 1, "walks": 0, "places": 1}


def test_a_large_file_within_the_limits_is_walked_through_once(monkeypatch: pytest.MonkeyPatch) -> None:
    work = counted(monkeypatch)
    text = "name: tool\nlink: {port: x}\nsequence:\n" + f"- a  # {'.' * 15}\n" * (NODES - 20)
    assert 200_000 < len(text) < 256 * 1024
    faults = examine_text(text, "tool.yaml").faults
    assert faults
    assert "the file holds too much" not in {fault.what for fault in faults}
    assert work["walks"] == 0
    assert work["values"] == NODES - 20 + 9
    assert work["places"] <= 2 * NODES


UNFOLDED = "a: &a [1,1,1,1,1,1,1,1,1]\n" + "".join(
    f"{chr(98 + n)}: &{chr(98 + n)} [{','.join([f'*{chr(97 + n)}'] * 9)}]\n" for n in range(9)
)


def test_a_bomb_of_aliases_is_unfolded_no_further_than_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    work = counted(monkeypatch)
    faults = examine_text(UNFOLDED, "tool.yaml").faults
    said = [fault for fault in faults if fault.what == "the aliases unfold to too much"]
    assert [fault.expected for fault in said] == [f"at most {NODES} values"]
    assert work["values"] < 200
    assert work["places"] <= 10 * NODES


@pytest.mark.parametrize(
    "text", ["[" * 120_000 + "]" * 120_000, "{" * 240_000, big("- "), big("? "), big(": ")]
)
def test_deep_nesting_is_refused_at_its_first_level_too_many(
    text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    work = counted(monkeypatch)
    (fault,) = examine_text(text, "tool.yaml").faults
    assert (fault.what, fault.expected) == ("not YAML: nested too deep", "a few levels")
    assert work["values"] <= 2 * DEPTH


def test_places_are_found_without_reading_the_text_again() -> None:
    text = "one\ntwo\r\n\nthree"
    lines = LineStarts(text)
    assert [lines.position(index) for index in range(len(text) + 1)] == [
        position(text, index) for index in range(len(text) + 1)
    ]


def counted(monkeypatch: pytest.MonkeyPatch) -> dict[str, int]:
    """How many values were read, how many walks over the whole text it took, how many places were kept."""
    work = Counter[str](values=0, walks=0)
    compose, walk, keep = CountingComposer.compose_node, _yaml.position, LineStarts.position

    def composing(self: CountingComposer, parent: object, index: object) -> object:
        work["values"] += 1
        return compose(self, parent, index)

    def walking(text: str, index: int) -> tuple[int, int]:
        work["walks"] += 1
        return walk(text, index)

    def keeping(self: LineStarts, index: int) -> tuple[int, int]:
        work["places"] += 1
        return keep(self, index)

    monkeypatch.setattr(CountingComposer, "compose_node", composing)
    monkeypatch.setattr(_yaml, "position", walking)
    monkeypatch.setattr(LineStarts, "position", keeping)
    return work


# Whatever stands in the file: a description, or faults that are sentences with a place; no traceback.


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
