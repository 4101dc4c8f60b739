"""Whether the nodes that report periodically still do."""

from __future__ import annotations

from collections.abc import Iterable

from ._table import GONE_AFTER_S


class Presence:
    """Who was heard when; a node that was never heard has gone as well. Times in µs, monotonic."""

    def __init__(self, nodes: Iterable[str]) -> None:
        self._heard: dict[str, int | None] = dict.fromkeys(nodes)

    def heard(self, node: str, at_us: int) -> None:
        """It has just reported."""
        self._heard[node] = at_us

    def known(self, node: str) -> bool:
        """Whether it was ever heard."""
        return self._heard[node] is not None

    def gone(self, now_us: int) -> tuple[str, ...]:
        """Names of those that are silent for more than a second."""
        limit = GONE_AFTER_S * 1e6
        return tuple(name for name, at in self._heard.items() if at is None or now_us - at > limit)
