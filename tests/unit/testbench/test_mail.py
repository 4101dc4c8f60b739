from __future__ import annotations

import select
from pathlib import Path

import pytest

from end_effector_lab.testbench import Events, Record
from end_effector_lab.testbench._mail import Mail
from end_effector_lab.testbench._voice import Voice


def test_nothing_is_done_before_it_is_delivered(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    events, record = Events(tmp_path / "events"), Record(tmp_path / "record")
    mail = Mail(Voice(), events, record)
    assert not select.select([mail], [], [], 0)[0]
    mail.line("SODIMM_208", True, 1_500_000, 1_500_100)
    mail.frame(1_520_000, 1, {"bottom": -5}, True)
    assert select.select([mail], [], [], 0)[0]
    assert (tmp_path / "events").read_text() == (tmp_path / "record").read_text() == ""
    mail.deliver()
    assert not select.select([mail], [], [], 0)[0]
    assert capsys.readouterr().out == "1.500000 SODIMM_208 active\n"
    assert len((tmp_path / "events").read_text().splitlines()) == 2
    assert (tmp_path / "record").read_text() == "time_s,bottom\n0.000000,-0.005\n"
    for each in (mail, events, record):
        each.close()


def test_a_pipe_that_is_full_stops_nobody() -> None:
    mail = Mail(Voice(), None, None)
    for _ in range(70_000):  # more than a pipe holds
        mail.end()
    assert mail.ended
    mail.close()
