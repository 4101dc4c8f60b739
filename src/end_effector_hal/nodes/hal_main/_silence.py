"""Which of the nodes that report periodically are silent."""

from __future__ import annotations

from collections.abc import Iterable

from end_effector_hal.nodes.interface import GONE_AFTER_S


class Silence:
    """The time of the last report of each node; one that has never reported is silent. Times in µs, monotonic."""

    def __init__(self, nodes: Iterable[str]) -> None:
        self._reported_us: dict[str, int | None] = dict.fromkeys(nodes)

    def reported(self, node: str, at_us: int) -> None:
        """The node has just reported."""
        self._reported_us[node] = at_us

    def has_reported(self, node: str) -> bool:
        """Whether the node has ever reported."""
        return self._reported_us[node] is not None

    def silent(self, now_us: int) -> tuple[str, ...]:
        """Names of the nodes whose last report is older than a second."""
        limit = GONE_AFTER_S * 1e6
        return tuple(name for name, at in self._reported_us.items() if at is None or now_us - at > limit)
