"""Plays the simulation: `python -m tests.unit.arbiter.simulation.run [--runs N] [--first SEED] [--seed SEED]`."""

from __future__ import annotations

import argparse
import logging
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor

from tests.unit.arbiter.simulation.simulation import Met, play, table

CHUNK = 250


def part(seeds: range) -> tuple[Met, list[tuple[int, str]]]:
    """Some of the runs, in a process of its own."""
    logging.disable()
    met: Met = Counter()
    return met, play(seeds, met)


def main() -> int:
    """Play many seeds, or one; the exit code says whether nothing was violated."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=2_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, help="replay one run, and say what the arbiter logs")
    given = parser.parse_args()
    began, met = time.monotonic(), Counter[tuple[str, str]]()
    violated: list[tuple[int, str]] = []
    if given.seed is not None:
        logging.basicConfig(level=logging.INFO)
        runs, violated = 1, play([given.seed], met)
    else:
        runs, last = given.runs, given.first + given.runs
        parts = [range(at, min(at + CHUNK, last)) for at in range(given.first, last, CHUNK)]
        with ProcessPoolExecutor() as pool:
            for found, wrong in pool.map(part, parts):
                met += found
                violated += wrong
    lines = [table(met), *(f"seed {seed}: {what}" for seed, what in violated)]
    lines.append(f"{runs} runs, {len(violated)} violated, {time.monotonic() - began:.0f} s")
    sys.stdout.write("\n".join(lines) + "\n")
    return 1 if violated else 0


if __name__ == "__main__":
    sys.exit(main())
