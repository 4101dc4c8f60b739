"""Somebody asks a program, and waits for its answer, but not for ever."""

from __future__ import annotations

import queue
from collections.abc import Callable

from end_effector_hal.control import Answer, Status
from end_effector_hal.wires import now_us

from ._relay import Relay, Rest

ANSWER_US = 2_000_000


def ask(
    relay: Relay,
    question: Callable[[], tuple[Answer, list[Status]]],
    act: Callable[[list[Status]], Rest | None],
    *,
    waits: bool = False,
) -> Answer | None:
    """The answer, once what follows from it was done; None: none came.

    Args:
        relay: of the program.
        question: is asked in its turn, and never later than 2 s from now: what was given up is not executed.
        act: on the statuses that it gives.
        waits: the question itself waits for something: it is asked in the program's own thread.
    """
    answers: queue.SimpleQueue[Answer] = queue.SimpleQueue()
    until = now_us() + ANSWER_US

    def job() -> Rest | None:
        if now_us() >= until:
            return None
        answer, statuses = question()
        rest = act(statuses)

        def finish() -> None:
            if rest is not None:
                rest()
            answers.put(answer)

        if rest is not None:
            return finish
        answers.put(answer)
        return None

    def whole() -> None:
        if (rest := job()) is not None:
            rest()

    relay.bring((lambda: whole) if waits else job)
    try:
        return answers.get(timeout=ANSWER_US / 1_000_000 + 0.5)
    except queue.Empty:
        return None
