"""The table of the wrong products, for ``docs/reference/wrong_products.md``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from .arbiter import ARBITER
from .by_chance import recorded
from .controller import CONTROLLER
from .wrong_product import WrongProduct

HEAD = ("the mistake", "where it is made", "found by", "what objects", "random runs")
WHOLE_RUN = "(a grip and a drop)"


def wrong_products() -> str:
    """Both tables, and their figures."""
    parts = [
        f"{len(CONTROLLER)} wrong programs and {len(ARBITER)} wrong line arbiters. Most of the cases were "
        "written by hand. The last column says in which run of `eehal campaign --seed 0`, from 1 on, a rule was "
        f"broken first, or in how many runs none was; {_found()}. "
        "`python -m tests.unit.trials.mutants.by_chance` measures it, for as long as it is "
        "given. A whole `eehal matrix` plays every cell.",
        "## Programs, sensors and automata",
        _table(CONTROLLER),
        "## The line arbiter and its records",
        _table(ARBITER),
    ]
    return "\n\n".join(parts)


def _found() -> str:
    """How many were found by chance, a phrase."""
    tried = recorded().values()
    return f"{sum(each.run is not None for each in tried)} of {len(tried)} that were tried were found so"


def _table(mutants: Mapping[str, WrongProduct]) -> str:
    lines = [HEAD, ("---",) * len(HEAD), *(tuple(_cells(name, each)) for name, each in mutants.items())]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cells(name: str, mutant: WrongProduct) -> Iterator[str]:
    yield name
    yield f"`{mutant.place}`"
    cell = f", cell `{mutant.cell}`" if mutant.cell else ""
    yield f"{'cell' if mutant.is_cell else 'case'} `{mutant.found_by or WHOLE_RUN}`{cell}"
    yield mutant.rule
    chance = recorded().get(name)
    yield "" if chance is None else f"none of {chance.runs}" if chance.run is None else str(chance.run + 1)
