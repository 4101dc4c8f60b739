"""The listeners of a tool: each is called in a thread of its own, and its errors and delays do not reach the tool."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from end_effector_hal.errors import ReportedError
from end_effector_hal.runtime._error_text import error_text, sendable
from end_effector_hal.vocabulary import Alarm
from end_effector_hal.wires import now_us

_log = logging.getLogger("end_effector_hal.runtime")
MOST_WAITING = 1_000
"""Maximum number of items that wait for a slow listener; then the oldest is dropped."""
SLOW_US = 2_000_000
"""Longest call of a listener without an alarm, µs."""
END_S = 2.0
"""Longest time that the end of a tool waits for its listeners, s."""
T = TypeVar("T")


class Listening(Generic[T]):
    """Calls one listener in a thread of its own; its exceptions and delays only cause an alarm.

    After an exception the listener is still called with the next item. The alarm ends when it works again and a person
    has acknowledged the alarm.

    Args:
        listener: called with each item, in order.
        name: the listener's name in its alarm; empty: that of the function.
        on_alarm: called in the listener's thread when the alarm has changed.
        key: an item with the same key as the item before it is skipped; None: none is.
    """

    def __init__(
        self,
        listener: Callable[[T], None],
        name: str,
        on_alarm: Callable[[], None],
        key: Callable[[T], object] | None = None,
    ) -> None:
        self._listener, self._on_alarm = listener, on_alarm
        self._key = key
        self._last_key: object = object()  # equal to no key
        self._who = sendable(name or str(getattr(listener, "__qualname__", type(listener).__qualname__)))
        self._waiting: deque[T] = deque()
        self._changed = threading.Condition()
        self._closed = False
        self._called_at: int | None = None
        self._lost = 0
        self._failing = self._over = ""
        self._since = 0
        self._thread = threading.Thread(target=self._run, name=f"listener {self._who}", daemon=True)
        self._thread.start()

    def put(self, item: T) -> None:
        """Queue an item for the listener; never waits."""
        if self._key is not None:
            try:
                key, before = self._key(item), self._last_key
            except Exception:  # noqa: BLE001 it may raise anything
                key, before = object(), None
            self._last_key = key
            if key == before:
                return
        with self._changed:
            if len(self._waiting) >= MOST_WAITING:
                self._waiting.popleft()
                self._lost += 1
            self._waiting.append(item)
            self._changed.notify_all()

    @property
    def alarm(self) -> Alarm | None:
        """The alarm of the listener; None: it works, and has worked since the last acknowledgement."""
        self._look()
        text, over = self._failing or self._over, not self._failing
        return Alarm("listener.failed", self._who, {"text": text}, self._since, over) if text else None

    def acknowledge(self) -> None:
        """Forget an alarm that is over."""
        self._over = ""

    def close(self, until_s: float) -> None:
        """Call the listener with the waiting items, at most until ``until_s`` (seconds on the monotonic clock)."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if self._thread is not threading.current_thread():
            self._thread.join(max(0.0, until_s - time.monotonic()))

    def _look(self) -> None:
        since = self._called_at
        slow = since is not None and now_us() - since > SLOW_US
        if (slow or self._lost) and not self._failing:
            self._since = now_us()
            self._failing = f"The listener {self._who} is too slow for its calls."
            _log.error("%s", self._failing)

    def _run(self) -> None:
        while (item := self._next()) is not None:
            self._call(item[0])

    def _next(self) -> tuple[T] | None:
        with self._changed:
            self._changed.wait_for(lambda: self._waiting or self._closed)
            return (self._waiting.popleft(),) if self._waiting else None

    def _call(self, item: T) -> None:
        before = self._failing, self._over
        self._called_at = now_us()
        try:
            self._listener(item)
        except (Exception, SystemExit) as error:  # noqa: BLE001 it may raise anything
            if not self._failing:
                self._since = now_us()
                self._failing = f"The listener {self._who} failed: {error_text(error)}"
                _log.error("%s", self._failing, exc_info=not isinstance(error, ReportedError))
        else:
            self._worked()
        self._called_at = None
        if (self._failing, self._over) != before:
            self._on_alarm()

    def _worked(self) -> None:
        """End the alarm after a successful call; the alarm that is over reports the number of dropped items."""
        self._look()  # nobody may have looked before it returned
        with self._changed:
            lost, self._lost = self._lost, 0
        if self._failing:
            missed = f" {lost} were dropped." if lost else ""
            self._over, self._failing = f"{self._failing}{missed}", ""


class Audience:
    """All listeners of a tool; ``on_alarm`` is called in a listener's thread when :attr:`alarms` have changed."""

    def __init__(self, on_alarm: Callable[[], None]) -> None:
        self._on_alarm = on_alarm
        self._all: tuple[tuple[type, Listening[Any]], ...] = ()

    def add(
        self,
        kind: type[T],
        listener: Callable[[T], None],
        name: str = "",
        key: Callable[[T], object] | None = None,
    ) -> None:
        """Add a listener for items of one class; ``key``: see `Listening`."""
        self._all = (*self._all, (kind, Listening(listener, name, self._on_alarm, key)))

    def put(self, item: object) -> None:
        """Queue an item for every listener of its class; never waits."""
        for kind, each in self._all:
            if kind is type(item):
                each.put(item)

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """The alarms of all listeners."""
        return tuple(alarm for _, each in self._all if (alarm := each.alarm))

    def acknowledge(self) -> None:
        """Forget all alarms that are over."""
        for _, each in self._all:
            each.acknowledge()

    def close(self) -> None:
        """Pass the waiting items to the listeners, for two seconds at most; then no listener is called any more."""
        until_s = time.monotonic() + END_S
        for _, each in self._all:
            each.close(until_s)
