"""The results of the rounds of one part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import Any

from figures import figures
from usage import Usage

from ._matching import Latencies


@dataclass
class Result:
    """Latencies of the product and of its floor, block by block, and the usage of the processes.

    Attributes:
        product, floor: for each block, samples by name; the blocks alternated.
        left_out: the reasons for omitted blocks.
        losses: latencies of losses of a held part, from the frame that shows it to the state that reports it.
        usage: usage of each process while holding.
        floor_usage: usage of each process of the floor's chain while it ran.
    """

    product: list[Latencies] = field(default_factory=list)
    floor: list[Latencies] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    losses: Latencies = field(default_factory=dict)
    usage: Mapping[str, Usage] = field(default_factory=dict)
    floor_usage: Mapping[str, Usage] = field(default_factory=dict)

    def add(self, other: Result) -> None:
        """Add the results of a later round."""
        self.product += other.product
        self.floor += other.floor
        self.left_out += other.left_out
        for name, samples in other.losses.items():
            self.losses[name] = [*self.losses.get(name, []), *samples]
        self.usage = _together(self.usage, other.usage)
        self.floor_usage = _together(self.floor_usage, other.floor_usage)

    def pooled(self, name: str) -> tuple[list[int], list[int]]:
        """Return all samples of the product, and all of the floor."""
        return _pool(self.product, name), _pool(self.floor, name)

    def ratio(self, name: str) -> float | None:
        """Return the ratio of the medians."""
        product, floor = self.pooled(name)
        return median(product) / median(floor) if product and floor else None

    def block_ratios(self, name: str) -> list[float]:
        """Return the ratio of the medians of each pair of blocks, which shows how steady the ratio is."""
        pairs = zip(self.product, self.floor, strict=False)
        return [median(one[name]) / median(other[name]) for one, other in pairs if one[name] and other[name]]

    def as_json(self) -> dict[str, Any]:
        """Return the JSON for the results file."""
        return {
            "latencies_us": {name: self._latency(name) for name in self.names},
            "losses_us": {
                name: {"samples": samples, "figures": (f := figures(samples)) and vars(f)}
                for name, samples in self.losses.items()
            },
            "left_out": self.left_out,
            "usage": {name: vars(usage) for name, usage in self.usage.items()},
            "floor_usage": {name: vars(usage) for name, usage in self.floor_usage.items()},
            "samples_us": {"product": self.product, "floor": self.floor},
        }

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the latencies."""
        return tuple(self.product[0])

    def _latency(self, name: str) -> dict[str, Any]:
        product, floor = map(figures, self.pooled(name))
        return {
            "product": product and vars(product),
            "floor": floor and vars(floor),
            "ratio_of_medians": self.ratio(name),
            "block_ratios": self.block_ratios(name),
        }


def _together(earlier: Mapping[str, Usage], later: Mapping[str, Usage]) -> Mapping[str, Usage]:
    return {name: usage.joined(earlier.get(name)) for name, usage in later.items()}


def _pool(blocks: Sequence[Latencies], name: str) -> list[int]:
    return [sample for block in blocks for sample in block[name]]
