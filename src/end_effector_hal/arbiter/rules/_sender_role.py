"""The role of the predicate sender: one connection at a time. Pure: time is an argument, in µs."""

from __future__ import annotations

from typing import Generic, TypeVar

from end_effector_hal.errors import LineBusyError

T = TypeVar("T")


class SecondSenderError(LineBusyError):
    """Another process claims to read the sensors while the first one has the role.

    Args:
        what: one sentence.
        todo: what the reader can do about it.
        active: whether the first one still sends.
    """

    def __init__(self, what: str, *, todo: str, active: bool) -> None:
        super().__init__(what, todo=todo)
        self.active = active


class SenderRole(Generic[T]):
    """The connection that may say what the sensors prove.

    Args:
        silent_us: a connection that was silent for so long can lose the role to another process of its user.
    """

    def __init__(self, silent_us: int) -> None:
        self._silent_us = silent_us
        self._holder: T | None = None
        self._uid, self._token, self._process, self._last_sent = -1, "", "", 0

    def assign(self, connection: T, uid: int, token: str, process: str, at: int) -> T | None:
        """Give the role to a connection; returns the connection that had it, which has to be closed.

        Args:
            connection: that asks for the role.
            uid: of its process.
            token: identifies its process when it connects again.
            process: in words, for the sentences.
            at: now.

        Raises:
            SecondSenderError: another one has it; says which.
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
        """Whether this connection, which sends something now, has the role."""
        if connection is not self._holder:
            return False
        self._last_sent = at
        return True

    def leave(self, connection: T) -> None:
        """The connection has ended; if it had the role, that is free."""
        if connection is self._holder:
            self._holder = None
