"""A folder of results: whose it is, one writer at a time, lines that are distrusted, files that nobody loses."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path

import pytest
from pydantic import BaseModel, TypeAdapter

from end_effector_hal.errors import UsageError
from end_effector_lab.results import ResultsFolder, ResultsLayout

LAYOUT = ResultsLayout(
    "survey", "survey.json", "rows.jsonl", "Remove the line.", ("report.txt",), ("failures",)
)


class _Row(BaseModel):
    id: str
    n: int
    s: float


ROW = TypeAdapter(_Row)
GOOD = b'{"id": "a", "n": 1, "s": 0.5}\n'


def opened(path: Path, **mark: object) -> ResultsFolder:
    return ResultsFolder(path, LAYOUT, {"tool": "cups", "source": "1"} | mark)


def ids(path: Path) -> list[str]:
    with opened(path) as results:
        return [row.id for _, row in results.lines(ROW)]


def begun(path: Path, content: bytes = GOOD) -> Path:
    with opened(path):
        pass
    (path / "rows.jsonl").write_bytes(content)
    return path


def test_what_was_appended_is_read_again(tmp_path: Path) -> None:
    with opened(tmp_path / "new") as results:
        results.append({"id": "é\n", "n": 1, "s": 2})
        results.append({"id": "b", "n": 2, "s": 2.5})
    assert ids(tmp_path / "new") == ["é\n", "b"]


def test_a_last_line_that_was_cut_off_goes_and_the_rest_stays_as_it_is(tmp_path: Path) -> None:
    kept = begun(tmp_path, GOOD + GOOD[:9]) / "rows.jsonl"
    inode = kept.stat().st_ino
    assert ids(tmp_path) == ["a"]
    assert (kept.read_bytes(), kept.stat().st_ino) == (GOOD, inode)


@pytest.mark.parametrize(
    "line",
    [
        b"garbage",
        b"\xff\xfe",
        b"\0\0",
        b"[]",
        b"{}",
        b"",
        b"[" * 100_000,
        b'{"id": "b", "n": ' + b"9" * 5000 + b', "s": 1}',
        b'{"id": "b", "n": "1", "s": 1}',
        b'{"id": "b", "n": true, "s": 1}',
        b'{"id": null, "n": 1, "s": 1}',
        b"x" * 4_000_001,
    ],
    ids=lambda line: repr(line[:20]),
)
def test_a_line_that_does_not_fit_is_named_with_its_number(line: bytes, tmp_path: Path) -> None:
    content = GOOD + line + b"\n" + GOOD
    begun(tmp_path, content)
    with pytest.raises(UsageError) as error:
        ids(tmp_path)
    assert error.value.where == f"{tmp_path / 'rows.jsonl'}:2"
    assert error.value.todo.startswith("Remove the line.")
    assert len(str(error.value)) < 600
    assert str(error.value).isprintable()
    assert (tmp_path / "rows.jsonl").read_bytes() == content


def test_two_do_not_write_at_once(tmp_path: Path) -> None:
    with opened(tmp_path), pytest.raises(UsageError, match="Another process is writing"):
        opened(tmp_path)
    with opened(tmp_path):
        pass


@pytest.mark.parametrize("name", ["rows.jsonl", "report.txt", "failures"])
def test_what_no_mark_claims_is_of_somebody_else(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("mine") if "." in name else (tmp_path / name).mkdir()
    with pytest.raises(UsageError, match=f"holds {name} and no survey.json"):
        opened(tmp_path)
    assert [each.name for each in tmp_path.iterdir()] == [name]


def test_another_mark_is_refused_and_named(tmp_path: Path) -> None:
    begun(tmp_path)
    with pytest.raises(UsageError, match="of another state of the program's source"):
        opened(tmp_path, source="2")
    with pytest.raises(UsageError, match="of another seed"):
        opened(tmp_path, seed=3)
    assert ids(tmp_path) == ["a"]


@pytest.mark.parametrize("content", [b"", b"[]", b"\xff", b"[" * 50_000, b"{", b" " * 200_000])
def test_a_mark_that_is_none_is_refused(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "survey.json").write_bytes(content)
    with pytest.raises(UsageError, match=r"not a mark of a survey|more than"):
        opened(tmp_path)
    assert (tmp_path / "survey.json").read_bytes() == content


@pytest.mark.parametrize("name", ["survey.json", "rows.jsonl", "report.txt"])
def test_a_folder_or_a_link_in_place_of_a_file_is_refused_before_the_work(name: str, tmp_path: Path) -> None:
    folder, precious = tmp_path / "results", tmp_path / "precious"
    precious.write_text("precious")
    begun(folder)
    for make in (Path.mkdir, lambda path: path.symlink_to(precious)):
        (folder / name).unlink(missing_ok=True)
        make(folder / name)
        with pytest.raises(UsageError, match=r"This is not a file\."):
            opened(folder)
        (folder / name).rmdir() if make is Path.mkdir else (folder / name).unlink()
    assert precious.read_text() == "precious"


def test_a_file_in_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="cannot be made"):
        opened(tmp_path / "file")


def test_a_file_that_somebody_has_changed_stays_beside(tmp_path: Path) -> None:
    report = tmp_path / "report.txt"
    with opened(tmp_path) as results:
        assert results.write("report.txt", b"1") is None
        assert results.write("report.txt", b"2") is None
        report.write_text("theirs")
    with opened(tmp_path) as results:
        assert results.read("report.txt") == b"theirs"
        assert results.write("report.txt", b"3") == tmp_path / "report-1.txt"
    with opened(tmp_path) as results:
        assert results.write("report.txt", b"4") is None
        assert results.write("report.txt", b"5", keep=True) == tmp_path / "report-2.txt"
    found = {each.name: each.read_text() for each in tmp_path.glob("report*")}
    assert found == {"report.txt": "5", "report-1.txt": "theirs", "report-2.txt": "4"}


def test_a_full_disk_leaves_a_folder_that_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full)
        with pytest.raises(UsageError, match="No space left"):
            opened(tmp_path)
    assert list(tmp_path.iterdir()) == []
    with opened(tmp_path) as results:
        results.append({"id": "a", "n": 1, "s": 0.5})
        monkeypatch.setattr(os, "write", lambda fd, data: full() if len(data) < 20 else _write(fd, data[:20]))
        with pytest.raises(UsageError, match="No space left") as error:
            results.append({"id": "b", "n": 1, "s": 0.5})
    assert error.value.where == str(tmp_path / "rows.jsonl")
    assert json.loads((tmp_path / "survey.json").read_text())["tool"] == "cups"
    assert ids(tmp_path) == ["a"]


_write = os.write
