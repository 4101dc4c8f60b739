"""Prove a grid of values of a description: which combinations hold, their first failures and worst cases."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from decimal import Decimal, DecimalException
from io import StringIO
from itertools import product
from math import prod
from pathlib import Path

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from end_effector_hal.codecs import match_codec
from end_effector_hal.control import load_automata
from end_effector_hal.description import Description, examine, examine_text
from end_effector_hal.errors import DescriptionError, Diagnostic, ReportedError, UsageError
from end_effector_hal.verification.lemmas import prove_tool
from end_effector_lab.workers import ShippedAutomata, Workers

MOST = 10_000
"""Maximum number of combinations; each of them needs a proof."""
_TODO = "Write KEY=FROM:TO:STEP or KEY=A,B,C, such as actuators.cylinder.timeout_s=3:7:1."


@dataclass(frozen=True)
class Axis:
    """A key of the description that is varied, and its values.

    Attributes:
        key: with dots, such as ``actuators.cylinder.timeout_s``.
        values: as they would be written in the file.
    """

    key: str
    values: tuple[str, ...]


def read_axis(text: str) -> Axis:
    """Read ``KEY=FROM:TO:STEP``, both ends included, or ``KEY=A,B,C``; raises UsageError."""
    key, equals, given = text.partition("=")
    if not equals or not all(key.split(".")) or not given:
        raise UsageError("This is not a --sweep option.", where=text, todo=_TODO)
    values = _range(text, given) if ":" in given else tuple(each.strip() for each in given.split(","))
    if not all(values) or len(set(values)) < len(values):
        raise UsageError("A --sweep value is empty or repeated.", where=text, todo=_TODO)
    return Axis(key, values)


def combinations(axes: Sequence[Axis]) -> Iterator[dict[str, str]]:
    """Return every combination; the last axis changes fastest. Raises UsageError for a repeated key, or too many."""
    keys = [axis.key for axis in axes]
    if len(set(keys)) < len(keys):
        raise UsageError("Two --sweep options name the same key.", where=", ".join(keys))
    if (count := prod(len(axis.values) for axis in axes)) > MOST:
        raise UsageError(f"These are {count} combinations; {MOST} are the most.", todo="Choose larger steps.")
    return (dict(zip(keys, each, strict=True)) for each in product(*(axis.values for axis in axes)))


def _range(text: str, given: str) -> tuple[str, ...]:
    try:
        first, last, step = (Decimal(each) for each in given.split(":"))
        count = int((last - first) / step) + 1 if step > 0 else 0
    except (ValueError, DecimalException, OverflowError):
        raise UsageError("This is not a range of numbers.", where=text, todo=_TODO) from None
    if not 1 <= count <= MOST:
        raise UsageError(f"This range has no value, or more than {MOST}.", where=text, todo=_TODO)
    return tuple(f"{(first + step * number).normalize():f}" for number in range(count))


NOT_THERE = ("EE-205", "EE-206")
"""Codes of the errors for an unknown key, and for a key in a missing stanza that needs more keys."""


TABLE, DOCUMENT = "sweep.csv", "sweep.json"


@dataclass(frozen=True)
class Proven:
    """A combination with its verdict.

    Attributes:
        values: the values by key, as they would be written in the file.
        holds: whether every requirement holds.
        refused: why this is no valid description, which is then not proven; empty: it is valid.
        fails: the requirements that do not hold, in the order of the automata.
        open: the requirements that were not decided.
        why: the finding about the first requirement that fails.
        worst: worst cases by name, such as ``grip_s``, seconds; None: the response never starts, or the worst case is
            unknown.
        states, seconds: number of states and duration of the proof.
    """

    values: dict[str, str]
    holds: bool
    refused: str = ""
    fails: tuple[str, ...] = ()
    open: tuple[str, ...] = ()
    why: str = ""
    worst: dict[str, float | None] = field(default_factory=dict)
    states: int = 0
    seconds: float = 0.0


@dataclass(frozen=True)
class _Combination:
    values: dict[str, str]
    description: Description | None
    refused: str = ""

    @property
    def id(self) -> str:
        return ", ".join(f"{key}={value}" for key, value in self.values.items())


def sweep(
    path: Path,
    axes: Sequence[Axis],
    workers: Workers,
    on_progress: Callable[[int, int], None] = lambda _, __: None,
) -> list[Proven]:
    """Prove each combination; return the results in the order of the grid.

    Args:
        path: path of the description.
        axes: the keys that are varied, and their values.
        workers: the workers that prove them.
        on_progress: called with the number of proven combinations, and the number of all.

    Raises:
        DescriptionError, ModelError: the unchanged description is not valid, or a key of an axis is unknown.
        UsageError: too many combinations.
        WorkersError: the workers cannot be reached or do not fit, or some combinations were not proven.
    """
    description, text = _described(path)
    load_automata(description)
    wanted = [*combinations(axes)]
    for axis in axes:  # a key that is unknown is so in each combination
        _changed(text, path, {axis.key: axis.values[0]})
    found: dict[tuple[str, ...], Proven] = {}
    on_progress(0, len(wanted))
    items = (_changed(text, path, values) for values in wanted)
    for combination, proven in workers.each(_prove, ShippedAutomata.read(description), items):
        found[tuple(combination.values.values())] = proven
        on_progress(len(found), len(wanted))
    return [found[tuple(values.values())] for values in wanted]


def _described(path: Path) -> tuple[Description, str]:
    """Return the unchanged description and its text; raises DescriptionError if it is not valid."""
    examination = examine(path)
    if examination.description is None:
        raise DescriptionError(examination.diagnostics)
    return examination.description, examination.text


def _changed(text: str, path: Path, values: dict[str, str]) -> _Combination:
    """Return the description with other values, or why it is refused."""
    yaml, output = YAML(), StringIO()
    tree = yaml.load(text)
    for key, value in values.items():
        *stanzas, last = key.split(".")
        stanza = tree
        for name in stanzas:
            if not isinstance(stanza, dict):
                raise _unknown(path, key)
            stanza = stanza.setdefault(name, {})
        if not isinstance(stanza, dict):
            raise _unknown(path, key)
        try:
            stanza[last] = YAML(typ="safe", pure=True).load(value)
        except (YAMLError, ValueError, TypeError) as error:
            raise UsageError(f"This is not a value: {str(error).splitlines()[0]}.", where=value) from None
    yaml.dump(tree, output)
    examination = examine_text(output.getvalue(), path)
    diagnostics: Sequence[Diagnostic] = examination.diagnostics
    if unknown := [each for each in diagnostics if each.code in NOT_THERE]:
        raise DescriptionError(unknown)
    description = examination.description
    if description is not None:
        diagnostics = [fault.diagnostic(str(path)) for fault in match_codec(description).faults]
    if diagnostics:
        return _Combination(values, None, diagnostics[0].message)
    return _Combination(values, description)


def _unknown(path: Path, key: str) -> UsageError:
    return UsageError(f"There is no key {key!r}.", where=str(path), todo="`eehal schema` has all of them.")


def _prove(shared: ShippedAutomata, combination: _Combination) -> Proven:
    if combination.description is None:
        return Proven(combination.values, holds=False, refused=combination.refused)
    description = shared.of(combination.description)
    try:
        proof = prove_tool(description, load_automata(description))
    except ReportedError as error:  # the automata do not take these values
        return Proven(combination.values, holds=False, refused=str(error))
    failing = [each for each in proof.findings if each.decided and not each.holds]
    return Proven(
        combination.values,
        holds=proof.holds,
        fails=tuple(each.id for each in failing),
        open=tuple(each.id for each in proof.findings if not each.decided),
        why=failing[0].sentence if failing else "",
        worst={
            name: None if worst.computed_ms is None else worst.computed_ms / 1000
            for name, worst in proof.bounds.items()
        },
        states=proof.states,
        seconds=round(proof.seconds, 3),
    )


def table(axes: Sequence[Axis], found: Sequence[Proven]) -> list[list[str]]:
    """Return rows below a header: the values, the verdict, the first failure, the worst cases in seconds."""
    names = [*dict.fromkeys(name for each in found for name in each.worst)]
    rows = [[*(axis.key for axis in axes), "verdict", "fails first", *names]]
    for each in found:
        verdict = "refused" if each.refused else "fails" if each.fails else "holds" if each.holds else "open"
        worst = ("-" if (value := each.worst.get(name)) is None else f"{value:g}" for name in names)
        rows.append([*each.values.values(), verdict, each.fails[0] if each.fails else each.refused, *worst])
    return rows
