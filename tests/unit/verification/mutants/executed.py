"""What happens when a mutant is executed: does its executor behave otherwise, and does the monitor refuse it?

``python -m tests.unit.verification.mutants.executed --sample 200 --seed 2026`` prints a table by the kind of edit. Each
mutant is executed with the constants of the shipped tool, for the same random inputs as the file as it is; the monitor
of the true network watches. The search ends at the first run in which either is found out.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
from functools import cache
from random import Random

import click

from end_effector_hal.control import load_automata, model_constants
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import ModelError
from tests.unit.verification.mutants.test_executors import EXECUTED, INTERFACE, play
from timed_automata import Network, Observation, make_network
from timed_automata.monitor import Monitor
from tools.mutants import Mutant, mutants

HEADS = ("judged", "load error", "differs", "monitor", "neither")


class Executed:
    """Executes mutants of one network.

    Args:
        network: the file as it is.
        constants: of the tool.
        runs: how many runs a mutant has.
    """

    def __init__(self, network: Network, constants: dict[str, object], runs: int) -> None:
        self.network, self._constants, self._runs = network, constants, runs
        self._expected = cache(lambda seed: play(network, seed))

    def found_by(self, mutant: Mutant) -> set[str]:
        """``load error``; or ``differs`` and ``monitor``, where its executor is found out."""
        try:
            network = make_network(mutant.document, self._constants)  # type: ignore[arg-type]
        except ModelError:
            return {"load error"}
        found: set[str] = set()
        for seed in range(self._runs):
            seen: list[Observation] = []
            try:
                did = play(network, seed, seen.append)
            except ModelError:
                return {"load error"}
            if did != self._expected(seed):
                found.add("differs")
                if self._refused(seen):
                    found.add("monitor")
                    break
        return found

    def _refused(self, seen: list[Observation]) -> bool:
        monitor = Monitor(self.network, EXECUTED, INTERFACE)
        for observation in seen:
            monitor.observe(observation)
        monitor.end(max((observation.at for observation in seen), default=0))
        return any(objection.kind == "no run" for objection in monitor.objections)


def table(found: list[tuple[Mutant, set[str]]]) -> Iterator[str]:
    """A line for each kind of edit."""
    kinds: dict[str, Counter[str]] = {}
    for mutant, by in found:
        kinds.setdefault(mutant.operator, Counter()).update({"judged", *(by or {"neither"})})
    total: Counter[str] = Counter()
    for counts in kinds.values():
        total.update(counts)
    yield f"{'edit':22}" + "".join(f"{head:>12}" for head in HEADS)
    for kind, counts in [*sorted(kinds.items()), ("all", total)]:
        yield f"{kind:22}" + "".join(f"{counts[head]:>12}" for head in HEADS)


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description="Execute mutants of the shipped automata.")
    parser.add_argument("--sample", type=int, default=200)
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--runs", type=int, default=20, help="runs of a mutant")
    asked = parser.parse_args()
    tool = load(profile_path())
    network = load_automata(tool)
    every = list(mutants(network.document, EXECUTED))
    executed = Executed(network, model_constants(tool), asked.runs)  # type: ignore[arg-type]
    chosen = sorted(Random(asked.seed).sample(range(len(every)), min(asked.sample, len(every))))
    found = [(every[number], executed.found_by(every[number])) for number in chosen]
    click.echo(f"{len(found)} of {len(every)} mutants, seed {asked.seed}, {asked.runs} runs each:")
    for line in table(found):
        click.echo(line)


if __name__ == "__main__":
    main()
