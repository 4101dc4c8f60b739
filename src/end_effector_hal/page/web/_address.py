"""Where the page is served, and the secret of its address."""

from __future__ import annotations

from dataclasses import dataclass, field
from secrets import token_urlsafe

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")


@dataclass(frozen=True)
class PageAddress:
    """Host and port, the names by which a browser may ask for them, and the secrets of this start.

    Attributes:
        host: to listen on.
        port: to listen on.
        names: further names that a browser may use, beside the host (and those of loopback, if it is that).
        token: in the printed address; it is exchanged for a cookie.
        session: the cookie.
        csrf: what a POST must carry beside the cookie.
    """

    host: str
    port: int
    names: tuple[str, ...] = ()
    token: str = field(default_factory=lambda: token_urlsafe(24), repr=False)
    session: str = field(default_factory=lambda: token_urlsafe(24), repr=False)
    csrf: str = field(default_factory=lambda: token_urlsafe(24), repr=False)

    @property
    def url(self) -> str:
        """What is printed: it lets one in."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"http://{self.names[0] if self.names else host}:{self.port}/?token={self.token}"

    @property
    def hosts(self) -> frozenset[str]:
        """What may stand in ``Host``: another name would be somebody else's, rebound to this address."""
        own = f"[{self.host}]" if ":" in self.host else self.host
        names = {own, *self.names, *(LOOPBACK if self.loopback else ())}
        return frozenset(f"{name}:{self.port}".lower() for name in names)

    @property
    def loopback(self) -> bool:
        """Whether nobody on another machine can reach it."""
        return self.host in ("127.0.0.1", "localhost", "::1")

    @property
    def cookie(self) -> str:
        """Its name: two pages of one machine differ by their ports."""
        return f"eehal-{self.port}"
