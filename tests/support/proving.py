"""In the place of the process that reads the sensors: tells the line arbiter what they prove."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from end_effector_hal.arbiter import ArbiterClient, PredicateSender
from end_effector_hal.wires import now_us
from tests.support.patience import wait_until

REPEAT_S = 0.03


@contextmanager
def proving(socket: Path, **predicates: bool) -> Iterator[None]:
    """Tell it again and again until the end; it begins when the arbiter has heard it."""
    teller, ended = PredicateSender(socket), threading.Event()

    def tell() -> None:
        while not ended.wait(REPEAT_S):
            teller.send(predicates, now_us())
        teller.close()

    with ArbiterClient(socket, "look") as look:
        thread = threading.Thread(target=tell)
        thread.start()
        try:
            wait_until("what the sensors prove", lambda: look.status()["told"].keys() >= predicates.keys())
            yield
        finally:
            ended.set()
            thread.join()
