"""Every code of an error: its sentence, its exit code, and what the program advises."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise

from end_effector_hal.description import CODES
from end_effector_hal.errors import DescriptionError, ReportedError

from ._markdown import ROOT, nodes, plain, table, text_of

FAULTS = ROOT / "tests" / "unit" / "description" / "faults"
MOST = 4
"""Examples of a code."""


def errors() -> str:
    """First what can be wrong with a description, then all else."""
    return "\n\n".join([*_of_descriptions(), *_of_programs()])


def _of_descriptions() -> Iterator[str]:
    said = defaultdict(list)
    for path in sorted(FAULTS.glob("*.txt")):
        for sentence, code in re.findall(
            r"^> \d+:\d+: (.*) \[(EE-\d+)\]$", path.read_text(encoding="utf-8"), re.MULTILINE
        ):
            said[code].append(sentence)
    for code, sentence in _in_the_source():
        if code not in said:
            said[code].append(sentence)
    yield "## In a description (exit code 2)"
    yield (
        "What the program says begins with `file:line:column:`, tells what stands there, what is expected, and what was"
        " probably meant. The sentences below are examples; tests hold each of them."
    )
    for code, meaning in CODES.items():
        yield f"### {code}: {meaning}"
        if code in said:
            yield "\n".join(f"- {plain(each)}" for each in _differing(said[code]))


def _in_the_source() -> Iterator[tuple[str, str]]:
    """Of what tests have no example: the code of a fault, and the sentence behind it."""
    for _, inside in nodes("src"):
        for node in inside:
            if isinstance(node, ast.Call):
                for code, sentence in pairwise(map(text_of, node.args)):
                    if code in CODES and sentence:
                        yield code, sentence


def _differing(sentences: list[str]) -> list[str]:
    """Those that begin otherwise than the others."""
    found = {each.partition("(")[0]: each for each in reversed(sentences)}
    return sorted(found.values(), key=sentences.index)[:MOST]


def _of_programs() -> Iterator[str]:
    said = raised()
    yield "## While a program runs"
    yield (
        "With `--json` an error is one object with the code; in Python each is an exception of"
        " `end_effector_hal.errors`. Listed are the sentences that come with advice; `{…}` is filled in."
    )
    for each in sorted(_kinds(ReportedError), key=lambda kind: kind.code):
        meaning = " ".join((each.__doc__ or "").split("\n\n")[0].split())
        yield f"### {each.code}: `{each.__name__}`, exit code {each.exit_code}"
        yield plain(meaning)
        if rows := [row for row in said[each.__name__] if row[1]]:
            yield table(("says", "what to do"), rows)


def _kinds(kind: type[ReportedError]) -> Iterator[type[ReportedError]]:
    yield kind
    for each in kind.__subclasses__():
        if each.__module__ in (ReportedError.__module__, DescriptionError.__module__):
            yield from _kinds(each)


def raised() -> dict[str, list[tuple[str, str]]]:
    """What the code raises, by class of error: each sentence with its advice."""
    found: dict[str, dict[str, str]] = {each.__name__: {} for each in _kinds(ReportedError)}
    for _, inside in nodes("src"):
        for node in inside:
            match node:
                case ast.Call(func=ast.Name(id=name), args=[first, *_], keywords=keywords) if (
                    name in found and text_of(first)
                ):
                    advice = next((text_of(each.value) for each in keywords if each.arg == "todo"), "")
                    found[name][plain(text_of(first))] = plain(advice)
    return {name: sorted(said.items()) for name, said in found.items()}
