"""Check all requirements in one exploration; search the shortest run for those that do not hold.

With free sensors, any reading may change to any value at any time, without memory.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from time import perf_counter

from end_effector_hal.errors import RangeError, StoppedError, UsageError
from end_effector_hal.verification.proof._checks import (
    CHECKS,
    checks,
    not_decided,
    open_checks,
    without_unused,
)
from end_effector_hal.verification.proof._finding import (
    UNMET,
    Finding,
    Proof,
    Requirement,
    WorstCase,
    stored_requirements,
)
from end_effector_hal.verification.proof._memory import MemoryBound
from timed_automata import Network, Trace
from timed_automata.explore import Explorer, Overview, ReactionBound, RunTimeError, Verdict, overview, relaxed
from timed_automata.queries import Query

FREE_SENSORS: Mapping[str, tuple[str, ...]] = {
    "actuators": ("FREE_SENSORS",),
    "all": ("FREE_SENSORS", "FREE_TOOL"),
}
"""Constants of the UPPAAL file that set sensors free, by the affected sensors: ``all`` includes those of the tool
changer.
"""


def free_constants(network: Network, which: str) -> dict[str, bool]:
    """Return the constants of a network's file that set its sensors free.

    Args:
        network: as its file or its description defines it.
        which: a key of `FREE_SENSORS`.

    Raises:
        UsageError: the file does not declare them.
    """
    names = FREE_SENSORS[which]
    if missing := [name for name in names if name not in network.constants]:
        raise UsageError(
            f"These automata declare no constant {' and no '.join(missing)}: their sensors cannot be set free.",
            where=network.document.path,
            todo="Leave out --free-sensors, or declare and use it as the shipped file does.",
        )
    return dict.fromkeys(names, True)


Progress = Callable[[str, int], None]
_FAR = 4  # times the required bound: a worst case beyond is told as "at least"
_LONG = 10  # times the states of the whole proof that may be spent on worst cases


def prove(
    network: Network,
    progress: Progress | None = None,
    *,
    executed: Collection[str] = (),
    flickers: bool = False,
    most_bytes: int | None = None,
) -> Proof:
    """Prove or refute every requirement of a network.

    Args:
        network: with the constants of a description, or with those of its file.
        progress: called now and then with the current activity and the number of states so far.
        executed: templates that a program executes: their time-outs must leave the room `D`, a constant of the file.
        flickers: whether its sensors may change any number of times at one instant. Such a run is endless and takes no
            time, so that only timelocks are checked, not whether time diverges.
        most_bytes: maximum memory of this process; None: see `MemoryBound`. Requirements that need more stay
            undecided.

    A query that is not well-formed, or outside of the supported subset, stays undecided; the others are answered.

    Raises:
        ModelError: two queries have the same id.
    """
    bound = MemoryBound(most_bytes)
    proving = _Proving(network, progress or (lambda *_: None), executed, flickers, bound)
    proof = proving.proof()
    findings = list(proof.findings)
    for at, finding in proving.unread:
        findings.insert(at, finding)
    return replace(proof, findings=tuple(findings))


class _Proving:
    def __init__(
        self,
        network: Network,
        progress: Progress,
        executed: Collection[str],
        flickers: bool,
        memory: MemoryBound,
    ) -> None:
        self.flickers, self.memory = flickers, memory
        self.stopped, self.states = False, 0
        stored = stored_requirements(network)
        self.requirements = tuple(each for each in stored if isinstance(each, Requirement))
        self.unread = [(at, each) for at, each in enumerate(stored) if isinstance(each, Finding)]
        self.network, self.progress, self.begun = network, progress, perf_counter()
        bound = network.constants.get("D")
        self.reaction = ReactionBound(executed, bound) if executed and isinstance(bound, int) else None

    def proof(self) -> Proof:
        queries = [requirement.query for requirement in self.requirements]
        try:
            found = overview(self.network, queries, self._telling("all requirements"), reaction=self.reaction)
            seconds = perf_counter() - self.begun
            found = without_unused(self.network, found, self._telling("all requirements"))
        except RangeError as error:
            return self._out_of_range(error)
        except StoppedError as error:
            return self._all_open(not_decided(error))
        explorer = Explorer(self.network, self._telling("the shortest runs"))
        others = self._others(explorer, found)
        extra = checks(explorer, found, self.reaction, flickers=self.flickers)
        answered = sum(answer is not None for answer in found.answers)
        share = seconds / max(1, answered + sum(not check.seconds for check in extra))
        findings = [
            others.get(number) or self._finding(number, requirement, found, share)
            for number, requirement in enumerate(self.requirements)
        ]
        findings += [
            check if check.seconds else replace(check, states=found.states, seconds=share) for check in extra
        ]
        off = tuple(map(str, found.coverage.disabled))
        stopped = self.stopped or not all(check.decided for check in extra)
        return Proof(tuple(findings), found.states, perf_counter() - self.begun, off, stopped)

    def _telling(self, what: str) -> Callable[[int], None]:
        """Return the progress function of an exploration; it stops the exploration when there is too little memory."""

        def tell(states: int) -> None:
            self.states = states
            self.progress(what, states)
            self.memory.check(states)

        return tell

    def _all_open(self, remark: str) -> Proof:
        findings = [each.finding(False, 0, 0.0, remark, decided=False) for each in self.requirements]
        findings += open_checks(self.reaction, remark, flickers=self.flickers)
        return Proof(tuple(findings), self.states, perf_counter() - self.begun, stopped=True)

    def _open(self, number: int, error: StoppedError) -> Finding:
        self.stopped = True
        return self.requirements[number].finding(False, 0, 0.0, not_decided(error), decided=False)

    def _finding(self, number: int, requirement: Requirement, found: Overview, share: float) -> Finding:
        """Return the finding of a requirement that the one exploration has answered."""
        unmet = UNMET if number in found.unmet else ""
        holds = found.answers[number] is True
        worst = None
        if response := found.bounded.get(number):
            longest = response.longest
            worst = WorstCase(longest.value if longest else None, response.most)
        remark = unmet or self._nowhere(number, holds=holds)
        return requirement.finding(holds, found.states, share, remark, worst=worst)

    def _nowhere(self, number: int, *, holds: bool) -> str:
        """Return the remark of an ``E<>`` query that does not hold: no run can be shown."""
        return "no run leads there" if self.requirements[number].query.kind == "E<>" and not holds else ""

    def _others(self, explorer: Explorer, found: Overview) -> dict[int, Finding]:
        """Return the findings that the one exploration left open: refuted with the shortest run, or of another kind."""
        open_ = [number for number, answer in enumerate(found.answers) if answer is None]
        kinds = {number: self.requirements[number].query.kind for number in open_}
        together = [number for number in open_ if kinds[number] in ("A[]", "E<>")]
        findings: dict[int, Finding] = {}
        if together:
            self.progress("the shortest runs", 0)
            begun = perf_counter()
            try:
                verdicts = explorer.check_all([self.requirements[number].query for number in together])
            except StoppedError as error:
                findings |= {number: self._open(number, error) for number in together}
            else:
                share = (perf_counter() - begun) / len(together)
                for number, verdict in zip(together, verdicts, strict=True):
                    findings[number] = self._exact(number, verdict, share)
        late = [
            number
            for number in together
            if number in found.bounded and findings[number].decided and not findings[number].holds
        ]
        for number, worst in self._worst_cases(late, found).items():
            findings[number] = replace(findings[number], worst=worst, remark=_told(worst))
        for number in open_:
            if number not in findings:
                requirement, begun = self.requirements[number], perf_counter()
                self.progress(requirement.id, 0)
                try:
                    verdict = explorer.check(requirement.query)
                except StoppedError as error:
                    findings[number] = self._open(number, error)
                else:
                    findings[number] = self._exact(number, verdict, perf_counter() - begun)
        return findings

    def _worst_cases(self, late: list[int], found: Overview) -> dict[int, WorstCase]:
        """Return how late responses can be that miss their bound, from one more exploration of limited size."""
        if not late:
            return {}
        most = {number: _FAR * max(1, found.bounded[number].most) for number in late}
        try:
            wider = overview(
                self.network,
                [relaxed(self.requirements[number].query, most[number]) for number in late],
                self._telling("worst cases"),
                most_states=_LONG * max(found.states, 1000),
            )
        except StoppedError:
            return {}  # that it is late has been shown
        answers = {}
        for at, number in enumerate(late):
            declared, seen = found.bounded[number].most, wider.bounded[at]
            if wider.ended or seen.longest is None:
                answers[number] = WorstCase(None, declared, max(seen.at_least, declared))
            else:
                answers[number] = WorstCase(seen.longest.value, declared)
        return answers

    def _exact(self, number: int, verdict: Verdict, seconds: float) -> Finding:
        remark, trace = ", ".join(map(str, verdict.extremes)), None if verdict.holds else verdict.trace
        remark = remark or self._nowhere(number, holds=verdict.holds)
        return self.requirements[number].finding(verdict.holds, verdict.states, seconds, remark, trace)

    def _out_of_range(self, found: RangeError) -> Proof:
        """Return the proof of a network in which a run, or a query, leaves a range; no other requirement is decided."""
        self.progress("the shortest run", 0)
        explorer = Explorer(self.network, self._telling("the shortest run"))
        queries: list[Query | str] = ["A[] true", *(each.query for each in self.requirements)]
        for query in queries:
            try:
                explorer.check(query)
            except RunTimeError as error:
                return self._left_range(error, error.trace)
            except RangeError as error:  # in what the query asks: there is no step that does it
                return self._left_range(error, None)
            except StoppedError:
                return self._left_range(found, None)
        raise AssertionError("a value leaves its range in no run")

    def _left_range(self, error: RangeError, trace: Trace | None) -> Proof:
        what, steps, seconds = str(error), len(trace.steps) if trace else 0, perf_counter() - self.begun
        first = Finding("ranges", CHECKS["ranges"], "", False, steps, seconds, what, trace)
        undecided = "not decided: see [ranges]"
        rest = [each.finding(False, 0, 0.0, undecided, decided=False) for each in self.requirements]
        return Proof((first, *rest), first.states, seconds)


def _told(worst: WorstCase) -> str:
    if worst.at_least_ms is not None:
        return f"takes at least {worst.at_least_ms} ms, {worst.declared_ms} ms are required"
    return f"takes up to {worst.computed_ms} ms, {worst.declared_ms} ms are required"
