"""The role of the predicate sender; one connection at a time has it. Pure: time is an argument, in µs."""

from __future__ import annotations

from typing import Generic, TypeVar

from end_effector_hal.errors import LineBusyError

T = TypeVar("T")


class SecondSenderError(LineBusyError):
    """Another process claims to read the sensors while the first one has the role.

    Args:
        what: one sentence.
        todo: advice for the reader of the message.
        active: whether the first process still sends.
    """

    def __init__(self, what: str, *, todo: str, active: bool) -> None:
        super().__init__(what, todo=todo)
        self.active = active


class SenderRole(Generic[T]):
    """The connection that may report predicates.

    Args:
        silent_us: after this silence another process of the same user may get the role.
    """

    def __init__(self, silent_us: int) -> None:
        self._silent_us = silent_us
        self._holder: T | None = None
        self._uid, self._token, self._process, self._last_sent = -1, "", "", 0

    def assign(self, connection: T, uid: int, token: str, process: str, at: int) -> T | None:
        """Give the role to a connection; return the connection that had it and must be closed.

        Args:
            connection: the connection that asks for the role.
            uid: user of its process.
            token: identifies its process when it connects again.
            process: the process in words, for messages.
            at: the time now.

        Raises:
            SecondSenderError: another connection has the role; the message names its process.
        """
        before = self._holder
        if before is not None and (uid, token) != (self._uid, self._token):
            active = at - self._last_sent < self._silent_us
            if active or uid != self._uid:
                reason = "still reports" if active else "belongs to another user"
                raise SecondSenderError(
                    f"a second process ({process}) wants to report what the sensors show; the arbiter ignores it, "
                    f"because the first one ({self._process}) {reason}.",
                    todo="Stop one of them: only one process reads the sensors.",
                    active=active,
                )
        self._holder, self._uid, self._token, self._process = connection, uid, token, process
        self._last_sent = at
        return before

    def accepts(self, connection: T, at: int) -> bool:
        """Return whether this connection, which sends a message now, has the role."""
        if connection is not self._holder:
            return False
        self._last_sent = at
        return True

    def leave(self, connection: T) -> None:
        """Free the role if this connection, which has ended, had it."""
        if connection is self._holder:
            self._holder = None
