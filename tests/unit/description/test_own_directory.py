"""The last resort for the run directory: somebody else may have been there first, with another user's rights."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from end_effector_hal.arbiter import run_arbiter
from end_effector_hal.description import _paths, load, profile_path, run_directory
from end_effector_hal.errors import ReportedError

VICTIM, OTHER = 65_534, 65_533


@pytest.fixture
def shared(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder such as /tmp, and no better place for a run directory."""
    with tempfile.TemporaryDirectory(prefix="eehal-") as folder:
        os.chmod(folder, 0o1777)
        monkeypatch.setattr(_paths, "SHARED", Path(folder))
        monkeypatch.setattr("os.access", lambda *_: False)
        for name in ("EEHAL_RUN_DIR", "XDG_RUNTIME_DIR"):
            monkeypatch.delenv(name, raising=False)
        yield Path(folder)


def as_user(uid: int, do: Callable[[], object]) -> str:
    """What it returns, or its error, in a process of that user."""
    reading, writing = os.pipe()
    if (child := os.fork()) == 0:
        try:
            os.setgroups([])
            os.setgid(uid)
            os.setuid(uid)
            said = str(do())
        except ReportedError as error:
            said = str(error)
        except BaseException as error:  # noqa: BLE001 whatever it is, the parent must see it
            said = repr(error)
        os.write(writing, said.encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as file:
        said = file.read()
    os.waitpid(child, 0)
    return said


def link_to_folder(shared: Path) -> Path:
    (shared / "mine").mkdir(mode=0o777)
    (shared / "mine").chmod(0o777)
    (shared / f"eehal-{VICTIM}").symlink_to(shared / "mine")
    return shared / "mine"


def folder_with_a_link(shared: Path) -> Path:
    prepared = shared / f"eehal-{VICTIM}"
    prepared.mkdir()
    prepared.chmod(0o777)
    (prepared / "verdin_gripper.sock.lock").symlink_to(shared / "precious")
    return prepared


def file_of_that_name(shared: Path) -> Path:
    (shared / f"eehal-{VICTIM}").write_text("x", encoding="ascii")
    return shared / f"eehal-{VICTIM}"


@pytest.mark.parametrize(
    ("prepare", "why"),
    [
        (link_to_folder, "it is a link, or no directory"),
        (folder_with_a_link, f"it belongs to the user {OTHER}"),
        (file_of_that_name, "it is a link, or no directory"),
    ],
)
def test_what_another_user_has_prepared_is_refused(
    shared: Path, prepare: Callable[[Path], Path], why: str
) -> None:
    precious = shared / "precious"
    precious.write_text("precious", encoding="ascii")
    os.chown(precious, VICTIM, VICTIM)
    as_user(OTHER, lambda: prepare(shared))
    before = sorted(shared.rglob("*"))
    tool = load(profile_path()).with_virtual(shared / "chip", "none", shared / "unused")
    tool = tool.model_copy(update={"lines": tool.lines.model_copy(update={"socket": None})})
    for attempt in (run_directory, lambda: run_arbiter(tool)):
        said = as_user(VICTIM, attempt)
        assert said.startswith(
            f"{shared}/eehal-{VICTIM}: the run directory is not for this user alone: {why}."
        ), said
        assert "Set EEHAL_RUN_DIR" in said
    assert precious.read_text(encoding="ascii") == "precious"
    assert sorted(shared.rglob("*")) == before, "nothing was left there"


def test_it_is_made_for_this_user_alone_and_found_again(shared: Path) -> None:
    for _ in range(2):
        assert as_user(VICTIM, run_directory) == f"{shared}/eehal-{VICTIM}"
    made = (shared / f"eehal-{VICTIM}").lstat()
    assert (made.st_uid, stat.filemode(made.st_mode)) == (VICTIM, "drwx------")


def test_one_that_others_may_write_is_refused_and_one_that_they_may_read_is_closed(shared: Path) -> None:
    path = shared / f"eehal-{VICTIM}"
    as_user(VICTIM, lambda: (path.mkdir(), path.chmod(0o775)))
    assert "others may write there" in as_user(VICTIM, run_directory)
    path.chmod(0o755)
    assert as_user(VICTIM, run_directory) == str(path)
    assert stat.filemode(path.stat().st_mode) == "drwx------"
