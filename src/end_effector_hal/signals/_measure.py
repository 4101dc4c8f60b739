"""How the values of a channel are displayed: with its unit, and as many decimals as its thresholds have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, Protocol, runtime_checkable


class Measure(NamedTuple):
    """The display format of a quantity; values are in thousandths of its unit (Pa for kPa).

    Attributes:
        unit: the unit for people, such as kPa or mm.
        decimals: number of decimals shown.
    """

    unit: str = "kPa"
    decimals: int = 1

    def text(self, value: int) -> str:
        """Return a value, given in thousandths of the unit, as text such as ``-12.3 kPa``."""
        return f"{value / 1000:.{self.decimals}f} {self.unit}"


GAUGE_PRESSURE = Measure()


@runtime_checkable
class MeasuredReadings(Protocol):
    """Readings that include the display format of their channels."""

    @property
    def measures(self) -> Mapping[str, Measure]:
        """Display format by channel; a channel that is not listed is a gauge pressure."""
        ...
