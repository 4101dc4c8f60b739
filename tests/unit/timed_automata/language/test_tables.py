"""The parser's tables are kept beside the bytecode; whatever stands there, a text is read the same."""

from __future__ import annotations

import sys
from importlib.util import cache_from_source
from pathlib import Path

import lark.lark
import pytest

from timed_automata.document import Text
from timed_automata.errors import ModelError
from timed_automata.language import _parser

GRAMMAR = Path(_parser.__file__).with_name("grammar.lark")


def kept_in(folder: Path, patch: pytest.MonkeyPatch) -> Path:
    patch.setattr(sys, "dont_write_bytecode", False)
    patch.setattr(sys, "pycache_prefix", str(folder))
    file = Path(f"{cache_from_source(str(GRAMMAR))}.lark")
    file.parent.mkdir(parents=True)
    return file


@pytest.fixture
def tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where they are kept, in a folder of this test."""
    return kept_in(tmp_path, monkeypatch)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, tuple[str, str]]:
    """They, and what is read by them."""
    with pytest.MonkeyPatch.context() as patch:
        file = kept_in(tmp_path_factory.mktemp("tables"), patch)
        found = read(patch)
        return file.read_bytes(), found


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """An item for each time that they are made."""
    items: list[str] = []
    make = lark.lark.load_grammar

    def counted(grammar: str, *rest: object) -> object:
        items.append(grammar)
        return make(grammar, *rest)

    monkeypatch.setattr(lark.lark, "load_grammar", counted)
    return items


def read(monkeypatch: pytest.MonkeyPatch) -> tuple[str, str]:
    """As a new process reads a text, and one with a fault."""
    parser = _parser._lark.__wrapped__()
    monkeypatch.setattr(_parser, "_lark", lambda: parser)
    good = _parser.parse(Text.plain("a + b[2] > 3 && !c", "m.xml"), "expression")
    with pytest.raises(ModelError) as fault:
        _parser.parse(Text.plain("a = struct", "m.xml"), "expression")
    return repr(good), str(fault.value)


def test_they_are_made_once(tables: Path, made: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as first:
        before = read(first)
    assert tables.stat().st_size > 10_000
    with monkeypatch.context() as second:
        assert read(second) == before
    assert len(made) == 1


@pytest.mark.parametrize("damage", [0, 10, 65, 100, 1_000, 50_000, -1])
def test_a_file_that_was_cut_off_is_made_again(
    tables: Path,
    made: list[str],
    whole: tuple[bytes, tuple[str, str]],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    damage: int,
) -> None:
    data, expected = whole
    tables.write_bytes(data[:damage])
    for _ in range(2):
        with monkeypatch.context() as again:
            assert read(again) == expected
    assert len(made) == 1
    assert capfd.readouterr() == ("", "")


def test_where_nothing_can_be_written_they_are_made_each_time(
    tables: Path, made: list[str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    tables.parent.rmdir()
    for _ in range(2):
        with monkeypatch.context() as each:
            read(each)
    assert len(made) == 2
    assert capfd.readouterr() == ("", "")


def test_who_wants_no_bytecode_gets_no_file(tables: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    with monkeypatch.context() as each:
        read(each)
    assert not tables.exists()
