"""What the product owns is opened through no link, and not where another user owns or may write it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from end_effector_hal.arbiter import ArbiterServer, Policy
from end_effector_hal.arbiter.records._storage import FileStorage
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ReportedError
from end_effector_hal.nodes.data_logger import CommandsLog
from end_effector_hal.owned import open_owned, owned_folder, write_owned
from end_effector_hal.recording._rows import RowFile
from end_effector_hal.verification.proof._verdict import Verdict, keep_verdict
from end_effector_hal.wires import Claim
from end_effector_hal.wires.lines import VirtualChip, VirtualLines
from end_effector_hal.wires.link import PtyPair
from end_effector_hal.wires.rpc import Listener
from end_effector_lab.testbench import write_virtual_copy
from tests.support.stranger import NOBODY

PRECIOUS = "precious\n"


@pytest.fixture
def folder() -> Iterator[Path]:
    """A socket's path is short."""
    with TemporaryDirectory(prefix="eehal-") as name:
        (Path(name) / "run").mkdir()
        (Path(name) / "precious").write_text(PRECIOUS)
        yield Path(name) / "run"


def arbiter(folder: Path) -> None:
    chip = VirtualChip.create(folder.parent / "chip", ["A"], exist_ok=True).path
    ArbiterServer(VirtualLines(chip), folder / "x.sock", Policy(["A"])).close()


def chip_lines(folder: Path) -> None:
    VirtualLines(folder / "chip").request(["A"])


MAKERS: dict[str, Callable[[Path], object]] = {
    "x.sock.lock": arbiter,
    "chip.lock": lambda folder: VirtualChip.create(folder / "chip", ["A"]),
    "uart.lock": lambda folder: PtyPair(folder / "uart"),
    "x.lock": lambda folder: Claim(folder / "x.lock", "the port"),
    "chip": chip_lines,
    "record": lambda folder: FileStorage(folder / "record", durable=False).write(0, b"x"),
    "states.csv": lambda folder: RowFile(folder / "states.csv", ["a"]),
    "commands.csv": lambda folder: CommandsLog(folder, float),
}


@pytest.mark.parametrize("name", MAKERS)
def test_a_link_is_not_followed(folder: Path, name: str) -> None:
    precious = folder.parent / "precious"
    if name == "chip":
        precious = VirtualChip.create(folder.parent / "other", ["A"]).path
    before = precious.read_bytes()
    (folder / name).symlink_to(precious)
    if name == "uart.lock":
        MAKERS[name](folder)
    else:
        with pytest.raises((ReportedError, OSError), match="it is a link"):
            MAKERS[name](folder)
    assert precious.read_bytes() == before


@pytest.mark.parametrize("name", [name for name in MAKERS if name not in ("uart.lock", "chip")])
def test_a_file_of_another_user_is_not_used(folder: Path, name: str) -> None:
    (folder / name).write_text(PRECIOUS)
    os.chown(folder / name, NOBODY, NOBODY)
    before = (folder / name).read_bytes()
    with pytest.raises((ReportedError, OSError), match=f"it belongs to the user {NOBODY}"):
        MAKERS[name](folder)
    assert (folder / name).read_bytes() == before
    os.chown(folder / name, 0, 0)
    (folder / name).chmod(0o666)
    with pytest.raises((ReportedError, OSError), match="others may write there"):
        MAKERS[name](folder)


def verdict(folder: Path) -> None:
    os.environ["XDG_STATE_HOME"] = str(folder / "state")
    keep_verdict(Verdict(hash="a", version="1", at="now", requirements=1))


FOLDERS: dict[str, Callable[[Path], object]] = {
    "": arbiter,
    ".": lambda folder: Listener(folder / "x.sock"),
    "state/end-effector-hal/verdicts": verdict,
    "copy": lambda folder: write_virtual_copy(load(profile_path()), folder / "copy"),
}


@pytest.mark.parametrize("name", FOLDERS)
@pytest.mark.parametrize("case", ["link", "other user", "world", "group", "above"])
def test_a_folder_that_others_rule_is_refused(
    folder: Path, name: str, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(folder))
    place = folder / name
    place.mkdir(parents=True, exist_ok=True)
    if case == "link":
        place.rmdir()
        (folder.parent / "elsewhere").mkdir()
        place.symlink_to(folder.parent / "elsewhere")
        why = "it is a link, or no directory"
    elif case == "other user":
        os.chown(place, NOBODY, NOBODY)
        why = f"it belongs to the user {NOBODY}"
    elif case == "above":
        place.parent.chmod(0o777)
        why = f"others may write in {place.parent}"
    else:
        place.chmod(0o777 if case == "world" else 0o775)
        why = "others may write there"
    with pytest.raises(ReportedError, match=why):
        FOLDERS[name](folder)
    assert not [*(folder.parent / "elsewhere").glob("*")]


def test_a_folder_that_is_shared_on_purpose_is_used(folder: Path) -> None:
    """As systemd and the image make it: for the group of those who may command the lines."""
    for mode in (0o1770, 0o2770):
        os.chown(folder, NOBODY, 0)
        folder.chmod(mode)
        assert owned_folder(folder) == folder
    os.chown(folder, NOBODY, NOBODY)
    folder.chmod(0o1770)
    with pytest.raises(OSError, match="it belongs to the user"):
        owned_folder(folder)


def test_a_file_is_replaced_and_what_is_no_file_is_not_waited_for(folder: Path) -> None:
    (folder / "file").symlink_to(folder.parent / "precious")
    write_owned(folder / "file", b"new")
    assert (folder / "file").read_bytes() == b"new"
    assert (folder.parent / "precious").read_text() == PRECIOUS
    os.mkfifo(folder / "pipe")
    for flags in (os.O_RDONLY, os.O_RDWR, os.O_WRONLY):
        with suppress(OSError):
            open_owned(folder / "pipe", flags)
            pytest.fail("a pipe is no file")
