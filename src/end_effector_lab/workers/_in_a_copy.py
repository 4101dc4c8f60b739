"""What begins alike is begun once, and goes on in a copy of the process each time."""

from __future__ import annotations

import os
import pickle
import threading
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


def in_a_copy(work: Callable[[], T]) -> T:
    """What ``work`` returns in a copy of this process, or raises there; whatever it changes is changed there only.

    If the copy dies, the work is done here. So it is in any thread but the main one, as in a worker of a cluster: only
    the thread that makes a copy goes on in it, and a lock that another one holds would never be released.
    """
    if threading.current_thread() is not threading.main_thread():
        return work()
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        code = 1
        try:
            os.close(read)
            with open(write, "wb") as file:
                file.write(_answer(work))
            code = 0
        finally:
            os._exit(code)  # nothing of this process is to be ended twice
    os.close(write)
    with open(read, "rb") as file:
        content = file.read()
    _, status = os.waitpid(child, 0)
    if status != 0:  # what came may be cut
        return work()
    succeeded, answer = pickle.loads(content)  # of this very program
    if not succeeded:
        raise answer
    return answer  # type: ignore[no-any-return]


def _answer(work: Callable[[], object]) -> bytes:
    try:
        return pickle.dumps((True, work()))
    except Exception as error:  # noqa: BLE001  it is raised on the other side
        told = pickle.dumps((False, error))
        pickle.loads(told)  # raises for one that cannot be made again: then the work is done by who asked
        return told
