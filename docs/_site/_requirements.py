"""Each requirement of the shipped automata: its sentence, its query, and what finds out that it does not hold."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

from end_effector_hal.control import network_of
from end_effector_hal.description import load, profile_path
from end_effector_hal.verification.lemmas import BUS_FILE, COILS_FILE, DEATHS_FILE
from end_effector_hal.verification.proof import Requirement, requirements_of
from timed_automata import load_network
from timed_automata.monitor import Monitor

from ._markdown import ROOT, link, plain, tests_with

FOLDER = "tests/unit/verification/"
MUTANTS = ROOT / FOLDER / "mutants" / "mutants.toml"


def requirements() -> str:
    """All of them, in the order of the file."""
    tool = load(profile_path())
    network, automata = network_of(tool), tool.automata
    monitor = Monitor(network, automata.executed, automata.interface, requirements=True)
    judged = [query.comment for query in monitor.queries]
    mutants = tomllib.loads(MUTANTS.read_text(encoding="utf-8"))["mutant"]
    parts = [
        part
        for each in requirements_of(network)
        for part in _requirement(
            each,
            any(f"[{each.id}]" in words for words in judged),
            [mutant for mutant in mutants if mutant["caught_by"] == each.id],
        )
    ]
    parts.append("## Of outputs with two coils")
    parts.append(
        "A network of their own proves them, with the times of each; that of the tool may then assume it."
    )
    parts += _apart(COILS_FILE)
    parts.append("## Of outputs on a bus")
    parts.append("A network of their own proves them, for whatever steps their commands have.")
    parts += _apart(BUS_FILE)
    parts.append("## Of deaths at any instant")
    parts.append("A network of its own proves them, once for all tools: `eehal verify --deaths`.")
    parts += _apart(DEATHS_FILE)
    return "\n\n".join(parts)


def _apart(file: Path) -> Iterator[str]:
    for each in requirements_of(load_network(file)):
        yield from (part.replace("## ", "### ", 1) for part in _requirement(each, False, []))


def _requirement(each: Requirement, judged: bool, found: list[dict[str, str]]) -> Iterator[str]:
    yield f"## `{each.id}`"
    yield plain(each.sentence)
    yield f"```text\n{each.query}\n```"
    if judged:
        yield "The trace of any run speaks of it; `eehal replay` judges it there."
    if found:
        yield "It finds these out:"
        yield "\n".join(
            f"- {mutant.get('template', 'declarations')}: {plain(mutant['name'])}" for mutant in found
        )
    named = re.compile(rf"""["'\\[]{re.escape(each.id)}["'\\]]""")
    tests = [path for path in tests_with(named) if f"{FOLDER}" in path.as_posix()]
    if tests:
        yield "Tests that name it: " + ", ".join(link(path) for path in tests) + "."
