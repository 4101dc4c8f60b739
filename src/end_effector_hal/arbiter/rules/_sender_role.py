"""Who may say what the sensors show: one connection at a time. Pure: time is an argument, in µs."""

from __future__ import annotations

from typing import Generic, TypeVar

from end_effector_hal.errors import LineBusyError

T = TypeVar("T")


class SecondSenderError(LineBusyError):
    """Somebody claims to read the sensors while another one does; ``heard`` says whether that one is heard."""

    heard = False


class SenderRole(Generic[T]):
    """The role, and the connection that has it.

    Args:
        silent_us: a connection that was not heard of for so long can lose the role to its own user.
    """

    def __init__(self, silent_us: int) -> None:
        self._silent_us = silent_us
        self._holder: T | None = None
        self._uid, self._token, self._process, self._heard = -1, "", "", 0

    def take(self, connection: T, uid: int, token: str, process: str, at: int) -> T | None:
        """A connection asks for the role, and has it; returns the one that had it, which has ended by that.

        Args:
            connection: that asks.
            uid: of its process.
            token: what it says to be known again.
            process: in words, for the sentences.
            at: now.

        Raises:
            SecondSenderError: another one has it; says who.
        """
        before = self._holder
        if before is not None and (uid, token) != (self._uid, self._token):
            heard = at - self._heard < self._silent_us
            if heard or uid != self._uid:
                error = SecondSenderError(
                    f"a second process ({process}) wants to say what the sensors show; it counts for nothing, "
                    f"for the first one ({self._process}) {'does' if heard else 'is of another user'}.",
                    todo="Stop one of them: one process reads the sensors.",
                )
                error.heard = heard
                raise error
        self._holder, self._uid, self._token, self._process = connection, uid, token, process
        self._heard = at
        return before

    def says(self, connection: T, at: int) -> bool:
        """Whether what this connection says counts; it was heard of now."""
        if connection is not self._holder:
            return False
        self._heard = at
        return True

    def leave(self, connection: T) -> None:
        """The connection has ended; if it had the role, that is free."""
        if connection is self._holder:
            self._holder = None
