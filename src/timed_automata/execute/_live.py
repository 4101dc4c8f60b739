"""The loop of an execution in real time; clock and waiting are arguments, as everywhere in this library."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from timed_automata.execute._execution import Execution
from timed_automata.execute._observations import Event, Step


def live(
    execution: Execution, clock_us: Callable[[], int], wait: Callable[[float | None], Event | None]
) -> Iterator[tuple[Step, ...]]:
    """Start an execution and yield the steps of every event and every deadline, until the caller ends the loop.

    Set the outputs of the device in the body of the loop. An event is received at the time at which ``wait`` returns.

    Args:
        execution: not started yet.
        clock_us: the present time, µs; for example ``lambda: time.monotonic_ns() // 1000``.
        wait: waits for an event for at most so many seconds (None: without limit); returns None if none came.

    Raises:
        UsageError: the execution is started already, or an event is no input.

    >>> for steps in live(execution, clock_us, wait):  # doctest: +SKIP
    ...     line.set_value(Value(execution.value("level")))
    """
    yield execution.start(clock_us())
    while True:
        due = execution.deadline
        event = wait(None if due is None else max(0, due - clock_us()) / 1e6)
        now = clock_us()
        yield execution.advance(now) if event is None else execution.receive(event, now).steps
