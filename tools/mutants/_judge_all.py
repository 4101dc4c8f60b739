"""Judges many mutants on all processors."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import zip_longest
from multiprocessing import get_context
from random import Random

from timed_automata import Network, make_network
from timed_automata.language import parse_cache, parsing_with
from timed_automata.network import Given

from ._edits import Mutant, mutants
from ._judge import Baseline, MutantOutcome, MutantVerdict, judge
from ._variants import variants

_worker: tuple[Baselines, list[Mutant]]
_DECIDED = MutantOutcome.CAUGHT, MutantOutcome.INVALID


class Baselines:
    """The unedited file with the tool's constants, and with those of its variants, explored when first needed.

    Args:
        network: the automata with the constants of a tool.
        constants: these constants, by name.
        executed: templates that a program executes.

    Raises:
        UsageError: a requirement does not hold of the unedited file.
    """

    def __init__(self, network: Network, constants: Mapping[str, Given], executed: Collection[str]) -> None:
        self._first = Baseline(network, constants, executed)
        self._variants = dict(variants(network, constants))
        self._explored: dict[str, Baseline] = {}
        self._parsed = parse_cache()

    def __iter__(self) -> Iterator[Baseline]:
        """Yield the tool at hand and its variants; the quickest, which catches most mutants, comes first."""
        for number, words in enumerate(self._variants):
            yield self._variant(words)
            if number == 0:
                yield self._first
        if not self._variants:
            yield self._first

    def _variant(self, words: str) -> Baseline:
        if words not in self._explored:
            constants = self._variants[words]
            network = make_network(self._first.network.document, constants)
            self._explored[words] = Baseline(network, constants, self._first.executed, words)
        return self._explored[words]

    def judge(self, mutant: Mutant) -> MutantVerdict:
        """Judge a mutant with the given tool and its variants until it is caught."""
        with parsing_with(self._parsed):
            return self._judge(mutant)

    def _judge(self, mutant: Mutant) -> MutantVerdict:
        found: list[MutantVerdict] = []
        for baseline in self:
            if found and baseline.stays_off(mutant):  # it is a model, as the first one has shown
                found.append(MutantVerdict(mutant, MutantOutcome.OFF))
                continue
            verdict = judge(mutant, baseline)
            if verdict.outcome in _DECIDED:
                return verdict
            found.append(verdict)
        worst = (MutantOutcome.OPEN, MutantOutcome.SURVIVES, MutantOutcome.EQUIVALENT, MutantOutcome.OFF)
        return min(found, key=lambda each: worst.index(each.outcome))


def judge_all(
    network: Network,
    constants: Mapping[str, Given],
    executed: Collection[str],
    *,
    sample: int | None = None,
    seed: int = 0,
    jobs: int | None = None,
) -> Iterator[MutantVerdict]:
    """Judge the mutants of the executed templates and of the global declarations; yield each verdict when it is found.

    Args:
        network: the automata with the constants of a tool.
        constants: these constants, by name.
        executed: templates that a program executes; only these, and the declarations that they use, are edited.
        sample: number of mutants, chosen by `drawn` with ``seed``; None: all of them.
        jobs: number of processes; None: one for each processor.

    Raises:
        UsageError: a requirement does not hold of the unedited file.
    """
    every = list(mutants(network.document, executed, constants))
    chosen = range(len(every)) if sample is None else sorted(drawn(every, sample, seed))
    baselines = Baselines(network, constants, executed)
    # a forked process has all of it already
    with ProcessPoolExecutor(jobs, get_context("fork"), _start, (baselines, every)) as pool:
        try:
            for number, (outcome, by, variant) in zip(chosen, pool.map(_judge, chosen), strict=True):
                yield MutantVerdict(every[number], outcome, by, variant)
        finally:
            pool.shutdown(cancel_futures=True)


def drawn(every: Sequence[Mutant], sample: int, seed: int) -> list[int]:
    """Return numbers of mutants: one of each edge, location and function in turn, so that none is omitted."""
    order = list(range(len(every)))
    Random(seed).shuffle(order)
    parts: dict[object, list[int]] = {}
    for number in order:
        one = every[number]
        part = one.template, one.location or one.element if one.edge is None else one.edge
        parts.setdefault(part, []).insert(0, number)
    turns = zip_longest(*parts.values())
    return [number for turn in turns for number in turn if number is not None][:sample]


def _start(baselines: Baselines, every: list[Mutant]) -> None:
    global _worker
    _worker = baselines, every


def _judge(number: int) -> tuple[MutantOutcome, tuple[str, ...], str]:
    """Return the verdict without the mutant, which the other process already has."""
    baselines, every = _worker
    judged = baselines.judge(every[number])
    return judged.outcome, judged.caught_by, judged.variant
