"""How many random runs each wrong product needs, for the table of them.

`python -m tests.unit.trials.mutants.by_chance --seed 0 --runs 150 --seconds 60` plays `eehal campaign` of the shipped
tool for each until a run breaks a rule, and keeps what it found in ``by_chance.json``; what stands there already for
the same seed is not played again. Seconds are of the processor, for each of them.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import pytest

from end_effector_hal.cli import write_whole
from end_effector_hal.description import load, profile_path
from end_effector_lab.trials import Campaign, run_campaign
from end_effector_lab.workers import LocalWorkers

from .arbiter import ARBITER
from .controller import CONTROLLER
from .wrong_product import WrongProduct

RECORD = Path(__file__).with_name("by_chance.json")


class Chance(NamedTuple):
    """What random runs have found of a wrong product.

    Attributes:
        run: the first that broke a rule, from 0; None: none did.
        runs: how many were played.
        kind: of the failure, a sentence; empty: there was none.
    """

    run: int | None
    runs: int
    kind: str


def recorded(seed: int = 0, record: Path = RECORD) -> dict[str, Chance]:
    """What stands in the record, by the name of the wrong product."""
    of_seed = json.loads(record.read_text(encoding="utf-8")).get(str(seed), {}) if record.exists() else {}
    return {name: Chance(*found) for name, found in of_seed.items()}


class _FoundError(Exception):
    """A run has broken a rule: the rest of the campaign, which looks for the smallest case, is left out."""


def first_failure(mutant: WrongProduct, seed: int, runs: int, seconds: float) -> Chance:
    """Play a campaign of a wrong product to its first failure."""
    until, last = time.process_time() + seconds, Campaign.runs

    def look(campaign: Campaign) -> None:
        nonlocal last
        last = campaign.runs
        if campaign.kinds:
            ((kind, failed), *_) = campaign.kinds.items()
            raise _FoundError(failed.run, kind)

    with pytest.MonkeyPatch.context() as patch, TemporaryDirectory() as folder:
        mutant.patch(patch)
        try:
            run_campaign(
                load(profile_path()),
                Path(folder) / "campaign",
                LocalWorkers(1),
                seed=seed,
                go_on=lambda _, run: run < runs and time.process_time() < until,
                on_progress=look,
            )
        except _FoundError as found:
            return Chance(found.args[0], last, found.args[1])
    return Chance(None, last, "")


def _how_hard(item: tuple[str, WrongProduct]) -> tuple[bool, int]:
    """What a short case finds is measured first."""
    return item[1].is_cell, item[1].found_by.count(";")


def main() -> int:
    """Play those that stand in no record yet."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--runs", type=int, default=150)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--record", type=Path, default=RECORD)
    asked = parser.parse_args()
    for name, mutant in sorted({**CONTROLLER, **ARBITER}.items(), key=_how_hard):
        known = recorded(asked.seed, asked.record)
        if name in known:
            continue
        known[name] = found = first_failure(mutant, asked.seed, asked.runs, asked.seconds)
        every = json.loads(asked.record.read_text(encoding="utf-8")) if asked.record.exists() else {}
        every[str(asked.seed)] = {each: list(chance) for each, chance in known.items()}
        write_whole(asked.record, (json.dumps(every, indent=1, ensure_ascii=False) + "\n").encode())
        sys.stdout.write(f"{name}: {found}\n")
        sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
