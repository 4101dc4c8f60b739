"""Where commands write: a file whole or not at all, and never in the place of what is no file."""

from __future__ import annotations

import errno
import os
import stat
import threading
from pathlib import Path

import click
import pytest

from end_effector_hal.cli._options import PathName, write_whole
from end_effector_hal.cli.recorded import part_of
from end_effector_hal.errors import UsageError
from end_effector_hal.page.web import PageAddress
from end_effector_hal.page.web._serve import _listen


def test_a_pipe_stays_a_pipe_and_gets_the_data(tmp_path: Path) -> None:
    pipe, got = tmp_path / "pipe", list[bytes]()
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()), daemon=True)
    reader.start()
    write_whole(pipe, b"data")
    assert stat.S_ISFIFO(pipe.stat().st_mode), "as a device in /dev would be gone"
    reader.join(10.0)
    assert got == [b"data"]


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    link, file = tmp_path / "link", tmp_path / "there" / "file"
    link.symlink_to(file)
    for data in (b"new", b"newer"):
        write_whole(link, data)
        assert (link.is_symlink(), file.read_bytes()) == (True, data)
    assert [each.name for each in file.parent.iterdir()] == ["file"]


def test_what_cannot_be_written_is_a_sentence(tmp_path: Path) -> None:
    for path, why in (
        (tmp_path, "Is a directory"),
        (tmp_path / "no" / "file", "No such file"),
        (Path("/dev/full"), "No space"),
    ):
        with pytest.raises(UsageError, match=f"The file cannot be written: {why}"):
            write_whole(path, b"data")
    assert not list(tmp_path.iterdir())


def test_a_path_that_leads_nowhere_is_a_sentence_in_every_command(tmp_path: Path) -> None:
    circle = tmp_path / "circle.mcap"
    circle.symlink_to(circle)
    for path, why in ((circle, "symbolic links"), (tmp_path / ("x" * 300), "too long")):
        with pytest.raises(click.BadParameter, match=f"cannot be reached: .*{why}"):
            PathName().convert(str(path), None, None)
    for fine in (tmp_path, tmp_path / "new", tmp_path / "new" / "below"):
        assert PathName().convert(str(fine), None, None) == fine


def test_a_folder_that_may_not_be_searched_is_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the kernel refuses it; root, who runs many tests, may search every folder."""
    folder, real = tmp_path / "folder", os.stat
    folder.mkdir()

    def refusing(path: str, *args: object, **options: object) -> os.stat_result:
        if str(path).startswith(f"{folder}/"):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)
        return real(path, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(os, "stat", refusing)
    with pytest.raises(click.BadParameter, match="cannot be reached: Permission denied"):
        PathName().convert(str(folder), None, None)


@pytest.mark.parametrize("seconds", [float("nan"), float("inf")])
def test_a_part_of_a_recording_is_between_numbers(seconds: float) -> None:
    with pytest.raises(UsageError, match="are seconds"):
        part_of(seconds, None)
    with pytest.raises(UsageError, match="are seconds"):
        part_of(None, seconds)


@pytest.mark.parametrize("host", ["a..b", "192.0.2.1"])
def test_a_host_that_is_no_name_or_not_of_this_machine_is_a_sentence(host: str) -> None:
    with pytest.raises(UsageError, match=r"The page cannot be served: .* Give an address .* to --host\."):
        _listen(PageAddress(host, 0))


def test_a_port_that_is_taken_is_a_sentence() -> None:
    with (
        _listen(PageAddress("127.0.0.1", 0)) as taken,
        pytest.raises(UsageError, match=r"The page cannot be served: .* Name another --port"),
    ):
        _listen(PageAddress("127.0.0.1", taken.getsockname()[1]))
