"""Many mutants, on all processors."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from random import Random

from end_effector_hal.verification.mutation._judge import Baseline, MutantOutcome, MutantVerdict, judge
from timed_automata import Network
from timed_automata.mutate import Mutant, mutants
from timed_automata.network import Given

_worker: tuple[Baseline, list[Mutant]]


def judge_all(
    network: Network,
    constants: Mapping[str, Given],
    executed: Collection[str],
    *,
    sample: int | None = None,
    seed: int = 0,
    jobs: int | None = None,
) -> Iterator[MutantVerdict]:
    """Judge the mutants of the executed templates, in the order of the file; each as it is found.

    Args:
        network: the automata with the constants of a tool.
        constants: these constants, by name.
        executed: templates that a program executes; only these are edited.
        sample: so many of them, drawn with ``seed``; None: all of them.
        jobs: processes; None: one for each processor.

    Raises:
        UsageError: a requirement does not hold of the file itself.
    """
    every = list(mutants(network.document, executed))
    chosen = list(range(len(every)))
    if sample is not None and sample < len(chosen):
        chosen = sorted(Random(seed).sample(chosen, sample))
    baseline = Baseline(network, constants, executed)
    # a forked process has all of it already
    with ProcessPoolExecutor(jobs, get_context("fork"), _start, (baseline, every)) as pool:
        try:
            for number, (outcome, by) in zip(chosen, pool.map(_judge, chosen), strict=True):
                yield MutantVerdict(every[number], outcome, by)
        finally:
            pool.shutdown(cancel_futures=True)


def _start(baseline: Baseline, every: list[Mutant]) -> None:
    global _worker
    _worker = baseline, every


def _judge(number: int) -> tuple[MutantOutcome, tuple[str, ...]]:
    """Without the mutant itself: it is known at the other side."""
    baseline, every = _worker
    judged = judge(every[number], baseline)
    return judged.outcome, judged.caught_by
