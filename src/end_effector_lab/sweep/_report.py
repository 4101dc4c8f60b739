"""A sweep for people: a table, and of two axes a map of each worst case."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from end_effector_lab.figures import HeatMapCell

from ._axis import Axis
from ._sweep import Proven

REFUSED = "refused"
GRIP = "grip_s"
"""What is looked at first."""


def table(axes: Sequence[Axis], found: Sequence[Proven]) -> list[list[str]]:
    """Rows with a head: the values, the verdict, what fails first, the worst cases in seconds."""
    names = [*dict.fromkeys(name for each in found for name in each.worst)]
    rows = [[*(axis.key for axis in axes), "verdict", "fails first", *names]]
    for each in found:
        worst = [_seconds(each.worst.get(name)) for name in names]
        rows.append([*each.values.values(), verdict(each), _first(each), *worst])
    return rows


def verdict(each: Proven) -> str:
    """In one word."""
    if each.refused:
        return REFUSED
    return "fails" if each.fails else "holds" if each.holds else "open"


def heat_maps(axes: Sequence[Axis], found: Sequence[Proven], output: Path) -> list[Path]:
    """A figure of each worst case over two axes; one file: only of the grip.

    Args:
        axes: two; the first one goes up.
        found: of all combinations.
        output: a folder, or a .png or .svg file.
    """
    from end_effector_lab.figures import heat_map, save  # with matplotlib

    up, along = axes
    names = [*dict.fromkeys(name for each in found for name in each.worst)]
    names.sort(key=lambda name: name != GRIP)
    single = output.suffix.lower() in (".png", ".svg")
    files = []
    for name in names[:1] if single else names:
        cells = {
            (each.values[along.key], each.values[up.key]): HeatMapCell(
                each.worst.get(name), "" if each.holds else _first(each) or verdict(each)
            )
            for each in found
        }
        title = f"Worst case of {name.removesuffix('_s').replace('_', ' ')}, s"
        figure = heat_map(title, (along.key, along.values), (up.key, up.values), cells)
        files.append(save(figure, output if single else output / f"{name}.png"))
    return files


def _first(each: Proven) -> str:
    return each.fails[0] if each.fails else each.refused


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:g}"
