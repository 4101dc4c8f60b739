"""``eehal arbiter --keep-awake`` asks the kernel to keep the processors awake, for as long as it runs."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from end_effector_hal.errors import WireError
from end_effector_hal.wires import processors_awake


def open_files() -> set[str]:
    return {os.readlink(link) for link in Path("/proc/self/fd").iterdir() if link.exists()}


def test_the_request_lasts_as_long_as_the_program(tmp_path: Path) -> None:
    device = tmp_path / "latency"
    with processors_awake(device):
        assert device.read_bytes() == bytes(4)
        assert str(device) in open_files()
    assert str(device) not in open_files()


def test_a_device_that_cannot_be_opened_is_named(tmp_path: Path) -> None:
    with pytest.raises(WireError, match=r"Is a directory\. .*--keep-awake"), processors_awake(tmp_path):
        raise AssertionError("it began")
