"""The address of the page, and its secrets."""

from __future__ import annotations

from dataclasses import dataclass, field
from secrets import token_urlsafe

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")


@dataclass(frozen=True)
class PageAddress:
    """Host and port, the names that a browser may use for them, and the secrets of this start.

    Attributes:
        host: host to listen on.
        port: port to listen on.
        names: further names that a browser may use, besides the host (and the loopback names, if the host is
            loopback).
        token: secret in the printed address; it is exchanged for a cookie.
        session: value of the cookie.
        csrf: secret that a POST must carry in addition to the cookie.
    """

    host: str
    port: int
    names: tuple[str, ...] = ()
    token: str = field(default_factory=lambda: token_urlsafe(24), repr=False)
    session: str = field(default_factory=lambda: token_urlsafe(24), repr=False)
    csrf: str = field(default_factory=lambda: token_urlsafe(24), repr=False)

    @property
    def url(self) -> str:
        """The printed address, which grants access by its token."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"http://{self.names[0] if self.names else host}:{self.port}/?token={self.token}"

    @property
    def hosts(self) -> frozenset[str]:
        """The values allowed in ``Host``; any other name may be a foreign one, rebound to this address."""
        own = f"[{self.host}]" if ":" in self.host else self.host
        names = {own, *self.names, *(LOOPBACK if self.loopback else ())}
        return frozenset(f"{name}:{self.port}".lower() for name in names)

    @property
    def loopback(self) -> bool:
        """Whether the page is unreachable from other machines."""
        return self.host in ("127.0.0.1", "localhost", "::1")

    @property
    def cookie(self) -> str:
        """Name of the cookie; it contains the port, since one machine may serve two pages."""
        return f"eehal-{self.port}"
