"""The address of the page with its secrets, and the access rules for requests; no I/O."""

from __future__ import annotations

from dataclasses import dataclass, field
from secrets import compare_digest, token_urlsafe

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
        scraper: secret by which a monitoring system reads ``/metrics``, and nothing else; empty: none may.
    """

    host: str
    port: int
    names: tuple[str, ...] = ()
    token: str = field(default_factory=lambda: token_urlsafe(24), repr=False)
    session: str = field(default_factory=lambda: token_urlsafe(24), repr=False)
    csrf: str = field(default_factory=lambda: token_urlsafe(24), repr=False)
    scraper: str = field(default="", repr=False)

    @property
    def url(self) -> str:
        """The printed address, which grants access by its token."""
        return f"http://{self.names[0] if self.names else self._own}:{self.port}/?token={self.token}"

    @property
    def _own(self) -> str:
        return f"[{self.host}]" if ":" in self.host else self.host

    @property
    def hosts(self) -> frozenset[str]:
        """The values allowed in ``Host``; any other name may be a foreign one, rebound to this address."""
        names = {self._own, *self.names, *(LOOPBACK if self.loopback else ())}
        return frozenset(f"{name}:{self.port}".lower() for name in names)

    @property
    def loopback(self) -> bool:
        """Whether the page is unreachable from other machines."""
        return self.host in ("127.0.0.1", "localhost", "::1")

    @property
    def cookie(self) -> str:
        """Name of the cookie; it contains the port, since one machine may serve two pages."""
        return f"eehal-{self.port}"


CSRF_HEADER = "x-eehal-csrf"
METRICS = "/metrics"
_NO_SCRAPER = "Send the secret of `eehal page --metrics-token FILE`: Authorization: Bearer SECRET."
_NOT_LET_IN = "Open the address that `eehal page` has printed: it has the token of this start."


@dataclass(frozen=True)
class Asked:
    """A request: its method, path, headers in lower case, and, if present, the page's cookie and the token."""

    method: str
    path: str
    headers: dict[str, str]
    cookie: str = ""
    token: str = ""


@dataclass(frozen=True)
class Refusal:
    """The HTTP status of a refused request, and a sentence."""

    status: int
    why: str


class Guard:
    """The access rules, all of which always apply, since a POST moves valves.

    Rule 1: The Host must be one of the page's own; a foreign name that resolves to this address is refused.
    Rule 2: A request with the token gets the cookie; every other request needs the cookie. A GET of ``/metrics`` may
        have the secret of the scraper instead.
    Rule 3: A request that another site started is refused, by Origin and by Sec-Fetch-Site.
    Rule 4: A POST needs the page's own Origin, and the page's CSRF token in a header.
    Rule 5: Methods other than GET, HEAD and POST are refused.
    """

    def __init__(self, address: PageAddress) -> None:
        self._address = address

    def refuse(self, asked: Asked) -> Refusal | None:
        """Return why a request is refused; None if it is served."""
        headers, host = asked.headers, asked.headers.get("host", "").lower()
        if host not in self._address.hosts:
            return Refusal(421, "This host name is not allowed. Restart with `eehal page --name HOSTNAME`.")
        if asked.method not in ("GET", "HEAD", "POST"):
            return Refusal(405, "Only GET and POST are allowed.")
        origin = headers.get("origin")
        if origin is not None and origin.lower() != f"http://{host}":
            return Refusal(403, "Another site has asked for this.")
        foreign = headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none")
        navigates = asked.method == "GET" and headers.get("sec-fetch-mode") == "navigate"
        if foreign and not navigates:
            return Refusal(403, "Another site has asked for this.")
        if self.lets_in(asked) or self._scrapes(asked):
            return None
        if not _same(asked.cookie, self._address.session):
            return Refusal(401, _NO_SCRAPER if asked.path == METRICS else _NOT_LET_IN)
        if asked.method == "POST" and origin is None:
            return Refusal(403, "A command needs an Origin header.")
        if asked.method == "POST" and not _same(headers.get(CSRF_HEADER, ""), self._address.csrf):
            return Refusal(403, "The command has no valid CSRF token. Reload the page.")
        return None

    def lets_in(self, asked: Asked) -> bool:
        """Return whether the request has the token, so that it gets the cookie."""
        return asked.method == "GET" and asked.path == "/" and _same(asked.token, self._address.token)

    def _scrapes(self, asked: Asked) -> bool:
        scheme, _, secret = asked.headers.get("authorization", "").partition(" ")
        known = bool(self._address.scraper) and scheme.lower() == "bearer"
        return (
            known and asked.method == "GET" and asked.path == METRICS and _same(secret, self._address.scraper)
        )


def _same(given: str, secret: str) -> bool:
    return compare_digest(given.encode(), secret.encode())
