"""All requirements in one exploration; what does not hold there is asked again, for the shortest run."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

from end_effector_hal.automata import Network, RangeError
from end_effector_hal.automata.explore import Explorer, Overview, RunTimeError, Verdict, overview

from ._checks import checks, without_unused
from ._finding import Finding, Proof, WorstCase
from ._requirement import Requirement, requirements_of

Progress = Callable[[str, int], None]


def prove(network: Network, progress: Progress | None = None) -> Proof:
    """Prove or refute every requirement of a network.

    Args:
        network: with the constants of a description, or as its file stands.
        progress: called now and then with what is being done, and the number of states so far.

    Raises:
        ModelError: a query is not well-formed, or outside of the supported subset.
    """
    return _Proving(network, progress or (lambda *_: None)).proof()


class _Proving:
    def __init__(self, network: Network, progress: Progress) -> None:
        self.requirements = requirements_of(network)
        self.network, self.progress, self.begun = network, progress, perf_counter()

    def proof(self) -> Proof:
        queries = [requirement.query for requirement in self.requirements]
        try:
            found = overview(self.network, queries, lambda states: self.progress("all requirements", states))
        except RangeError:
            return self._out_of_range()
        seconds = perf_counter() - self.begun
        found = without_unused(self.network, found)
        explorer = Explorer(self.network)
        others = self._others(explorer, found)
        extra = checks(self.network, explorer, found, lambda: self.progress("what may be wrong", 0))
        answered = sum(answer is not None for answer in found.answers)
        share = seconds / max(1, answered + sum(not check.seconds for check in extra))
        findings = [
            others.get(number) or self._finding(number, requirement, found, share)
            for number, requirement in enumerate(self.requirements)
        ]
        findings += [check.finding(found.states, share) for check in extra]
        notes = tuple(f"switched off by the constants: {edge}" for edge in found.missing.off)
        return Proof(tuple(findings), found.states, perf_counter() - self.begun, notes)

    def _finding(self, number: int, requirement: Requirement, found: Overview, share: float) -> Finding:
        """Of what the one exploration has answered."""
        unmet = "its premise holds nowhere" if number in found.unmet else ""
        holds = found.answers[number] is True
        worst = None
        if response := found.bounded.get(number):
            longest = response.longest
            worst = WorstCase(longest.value if longest else None, response.most)
        query = str(requirement.query)
        return Finding(
            requirement.id, requirement.sentence, query, holds, found.states, share, unmet, worst=worst
        )

    def _others(self, explorer: Explorer, found: Overview) -> dict[int, Finding]:
        """What is left open: refuted with the shortest run, or of another kind."""
        open_ = [number for number, answer in enumerate(found.answers) if answer is None]
        kinds = {number: self.requirements[number].query.kind for number in open_}
        together = [number for number in open_ if kinds[number] in ("A[]", "E<>")]
        findings: dict[int, Finding] = {}
        if together:
            self.progress("the shortest runs", 0)
            begun = perf_counter()
            verdicts = explorer.check_all([self.requirements[number].query for number in together])
            share = (perf_counter() - begun) / len(together)
            for number, verdict in zip(together, verdicts, strict=True):
                findings[number] = self._exact(explorer, number, verdict, share, found)
        for number in open_:
            if number not in findings:
                requirement, begun = self.requirements[number], perf_counter()
                self.progress(requirement.id, 0)
                verdict = explorer.check(requirement.query)
                findings[number] = self._exact(explorer, number, verdict, perf_counter() - begun, found)
        return findings

    def _exact(
        self, explorer: Explorer, number: int, verdict: Verdict, seconds: float, found: Overview
    ) -> Finding:
        requirement, worst, remark = self.requirements[number], None, ""
        if response := found.bounded.get(number):
            begun = perf_counter()
            self.progress(f"the worst case of {requirement.id}", 0)
            longest = explorer.check(response.supremum).extremes[0]
            seconds += perf_counter() - begun
            worst = WorstCase(longest.value, response.most)
            remark = f"takes up to {longest} ms, {response.most} ms are required"
        elif verdict.extremes:
            remark = ", ".join(map(str, verdict.extremes))
        return Finding(
            requirement.id,
            requirement.sentence,
            verdict.query,
            verdict.holds,
            verdict.states,
            seconds,
            remark,
            None if verdict.holds else verdict.trace,
            worst,
        )

    def _out_of_range(self) -> Proof:
        """A run of the network leaves a range: nothing else is said of such a model."""
        self.progress("the shortest run", 0)
        sentence = "Every value stays in its range, every index in its array."
        try:
            Explorer(self.network).check("A[] true")
            raise AssertionError("a value leaves its range in no run")
        except RunTimeError as error:
            what, trace = str(error), error.trace
        seconds = perf_counter() - self.begun
        first = Finding("ranges", sentence, "", False, len(trace.steps), seconds, what, trace)
        rest = [
            Finding(each.id, each.sentence, str(each.query), False, 0, 0.0, "not decided: see [ranges]")
            for each in self.requirements
        ]
        return Proof((first, *rest), first.states, seconds)
