"""How the values of a channel are shown: its unit, and as many decimals as its thresholds have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Protocol, runtime_checkable


class Measure(NamedTuple):
    """Of a pressure, or of another quantity; a value is in thousandths of the unit (Pa of kPa).

    Attributes:
        unit: for people, such as kPa or mm.
        decimals: that are shown.
    """

    unit: str = "kPa"
    decimals: int = 1

    def text(self, value: int) -> str:
        """``-12.3 kPa``, of thousandths."""
        return f"{value / 1000:.{self.decimals}f} {self.unit}"


GAUGE_PRESSURE = Measure()


@runtime_checkable
class MeasuredReadings(Protocol):
    """Readings that know how their channels are shown."""

    @property
    def measures(self) -> Mapping[str, Measure]:
        """By channel; one that is not listed is a gauge pressure."""
        ...
