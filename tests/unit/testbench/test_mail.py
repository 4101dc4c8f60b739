from __future__ import annotations

import signal
import threading
from pathlib import Path

import pytest

from end_effector_lab.testbench._program import Mail, Voice
from end_effector_lab.testbench._records import Events, Record


def test_nothing_is_done_before_it_is_delivered(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    events, record = Events(tmp_path / "events"), Record(tmp_path / "record")
    mail = Mail(Voice(), events, record)
    mail.line("SODIMM_208", True, 1_500_000, 1_500_100)
    mail.frame(1_520_000, 1, {"bottom": -5}, True)
    assert (tmp_path / "events").read_text() == (tmp_path / "record").read_text() == ""
    mail.deliver()
    assert capsys.readouterr().out == "1.500000 SODIMM_208 active\n"
    assert len((tmp_path / "events").read_text().splitlines()) == 2
    assert (tmp_path / "record").read_text() == "time_s,bottom\n0.000000,-0.005\n"
    for each in (events, record):
        each.close()


def test_what_is_posted_in_a_thread_is_done_in_its_order_until_the_end() -> None:
    mail, done = Mail(Voice(), None, None), list[int]()

    def post() -> None:
        for number in range(1000):
            mail.post(lambda number=number: done.append(number))
        mail.end()

    thread = threading.Thread(target=post)
    thread.start()
    mail.serve()
    mail.deliver()
    thread.join()
    assert done == list(range(1000))


def test_a_signal_ends_it_while_it_waits() -> None:
    mail = Mail(Voice(), None, None)
    before = signal.signal(signal.SIGUSR1, lambda *_: mail.end())
    main = threading.main_thread().ident
    assert main
    mail.post(lambda: signal.pthread_kill(main, signal.SIGUSR1))
    try:
        mail.serve()
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert mail.ended
