"""What begins alike is begun once, and goes on in a copy of the process each time."""

from __future__ import annotations

import os
import pickle
import warnings
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


def in_a_copy(work: Callable[[], T]) -> T:
    """What ``work`` returns in a copy of this process, or raises there; whatever it changes is changed there only.

    In a copy only this thread goes on. If the copy dies, the work is done here.
    """
    read, write = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", DeprecationWarning
        )  # other threads: the copy needs none of their locks
        child = os.fork()
    if child == 0:
        try:
            os.close(read)
            with open(write, "wb") as file:
                file.write(_answer(work))
        finally:
            os._exit(0)  # nothing of this process is to be ended twice
    os.close(write)
    with open(read, "rb") as file:
        content = file.read()
    os.waitpid(child, 0)
    if not content:
        return work()
    succeeded, answer = pickle.loads(content)  # of this very program
    if not succeeded:
        raise answer
    return answer  # type: ignore[no-any-return]


def _answer(work: Callable[[], object]) -> bytes:
    try:
        return pickle.dumps((True, work()))
    except Exception as error:  # noqa: BLE001  it is raised on the other side
        return pickle.dumps((False, error))
