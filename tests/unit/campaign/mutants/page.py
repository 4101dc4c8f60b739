"""The table of the wrong products, for ``docs/reference/wrong_products.md``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from .arbiter import ARBITER
from .controller import CONTROLLER
from .wrong_product import WrongProduct

HEAD = ("the mistake", "where it is made", "found by", "what objects")
WHOLE_RUN = "(a grip and a drop)"


def wrong_products() -> str:
    """Both tables, and their figures."""
    parts = [
        f"{len(CONTROLLER)} wrong programs and {len(ARBITER)} wrong line arbiters. Where a run stands behind a case, "
        "`eehal campaign --seed 0` breaks a rule in that run by itself; the other cases were written by hand. A whole "
        "`eehal matrix` plays every cell.",
        "## Programs, sensors and automata",
        _table(CONTROLLER),
        "## The line arbiter and its records",
        _table(ARBITER),
    ]
    return "\n\n".join(parts)


def _table(mutants: Mapping[str, WrongProduct]) -> str:
    lines = [HEAD, ("---",) * len(HEAD), *(tuple(_cells(name, each)) for name, each in mutants.items())]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cells(name: str, mutant: WrongProduct) -> Iterator[str]:
    yield name
    yield f"`{mutant.place}`"
    run = "" if mutant.found_in_run is None else f" (run {mutant.found_in_run})"
    cell = f", cell `{mutant.cell}`" if mutant.cell else ""
    yield f"{'cell' if mutant.is_cell else 'case'} `{mutant.found_by or WHOLE_RUN}`{run}{cell}"
    yield f"{'matrix' if mutant.is_cell else 'campaign'}: {mutant.rule}"
