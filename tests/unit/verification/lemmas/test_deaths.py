"""The network of deaths: it holds, and requirement 8 is found false wherever one of its protections is taken away."""

from __future__ import annotations

from pathlib import Path

import pytest
from _pytest.mark import ParameterSet
from click import Command
from click.testing import CliRunner

from end_effector_hal.cli._lab import draw_run
from end_effector_hal.cli._verify import command as verify
from end_effector_hal.cli.model._model import command as model
from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import RunInfo
from end_effector_hal.verification.lemmas import DEATHS_FILE, death_network
from end_effector_hal.verification.proof import (
    Finding,
    counterexample_run,
    prove,
    requirements_of,
    told_run,
)
from tests.unit.figures.layout_faults import layout_faults
from tests.unit.verification.mutants.conftest import Mutant, mutated
from timed_automata import load_document, load_network, make_network, read_document
from timed_automata.explore import Explorer

TEXT = DEATHS_FILE.read_text(encoding="utf-8")
TEMPLATES = load_document(DEATHS_FILE).templates


@pytest.mark.parametrize("template", TEMPLATES, ids=lambda each: each.name.content)
def test_it_reads_well(template) -> None:  # type: ignore[no-untyped-def]
    assert layout_faults(template) == []


@pytest.mark.thinned  # long
def test_eehal_verify_proves_it() -> None:
    result = CliRunner().invoke(verify, ["--deaths", "--all"], catch_exceptions=False)
    assert result.exit_code == 0
    assert "No line of a held part goes inactive except after a Drop, whichever process dies" in result.stdout


def test_its_network_is_exported(tmp_path: Path) -> None:
    own = tmp_path / "deaths.xml"
    result = CliRunner().invoke(model, ["export", "--deaths", "-o", str(own)], catch_exceptions=False)
    assert result.exit_code == 0
    assert load_network(own).constants["SETTLE"] == 50


@pytest.mark.parametrize(
    ("command", "words", "what"),
    [
        (verify, ["--deaths", "--free-sensors", "all"], "The network of deaths has no sensors"),
        (verify, ["--deaths", "--model", "lamp.xml"], "Two networks are named: --model and --deaths"),
        (verify, ["--registers", "a", "--model", "lamp.xml"], "Two networks are named: --model and --registers"),
        (model, ["show", "--deaths", "--coils", "cup"], "Two networks are named"),
    ],
)  # fmt: skip
def test_two_networks_at_once_are_refused(command: Command, words: list[str], what: str) -> None:
    with pytest.raises(UsageError, match=what):
        CliRunner().invoke(command, words, catch_exceptions=False)


def test_it_has_the_time_that_a_line_of_the_tool_settles() -> None:
    assert death_network(load(profile_path())).constants["SETTLE"] == 50


PLACES: list[Mutant] = [
    {
        "name": "last will executed late: another program is let in before it is over",
        "template": "Arbiter",
        "edge": "Idle -> Ready",
        "has": "hello?",
        "old": "todo == 0 &&",
        "new": "",
    },
    {
        "name": "journal stale: an older record, or one that is outdated, is believed",
        "template": "Arbiter",
        "code": True,
        "old": "return record != WHOLE ||",
        "new": "return",
    },
    {
        "name": "death between two lines: what waits to settle is carried out later, and nobody waits for it",
        "template": "Arbiter",
        "code": True,
        "old": "!in_set(todo, i)) todo += 1 + i;\n        waits[i] = NONE;",
        "new": "!in_set(todo, i)) waits[i] = WAITS_OFF;\n        else waits[i] = NONE;",
    },
    {
        "name": "restart without adoption: the lines become inactive outputs",
        "template": "Arbiter",
        "code": True,
        "old": "    session = kept_session == ABSENT",
        "new": "    for (i : line_t) set(i, false);\n    session = kept_session == ABSENT",
    },
    {
        "name": "held is told although the line arbiter was lost before it had the last will that holds",
        "template": "Program",
        "edge": "Holding -> Lost",
        "has": "falls?",
        "old": "r = 0",
        "new": "found = false, ee = GRIPPED, held = true, r = 0",
    },
    {
        "name": "held is told while a deactivation of its line waits, with an activation behind it",
        "template": "Program",
        "code": True,
        "old": " && waits[i] != WAITS_BOTH",
        "new": "",
    },
]


def refuted(mutant: Mutant) -> Finding:
    """Requirement 8 of a mutant, with its shortest run."""
    network = make_network(read_document(mutated(TEXT, mutant).encode(), "deaths.xml"), {})
    held = next(each for each in requirements_of(network) if each.id == "held")
    verdict = Explorer(network).check(held.query)
    assert not verdict.holds
    return held.finding(verdict.holds, verdict.states, 0.0, "", verdict.trace)


SLOWER = {
    "last will executed late": pytest.mark.thinned,
    "held is told although the line arbiter was lost before it had the last will that holds": pytest.mark.thinned,
    "death between two lines": pytest.mark.nightly,
    "journal stale": pytest.mark.nightly,
    "held is told while a deactivation of its line waits, with an activation behind it": pytest.mark.nightly,
}


def place(mutant: Mutant) -> ParameterSet:
    name = mutant["name"].split(":")[0]
    return pytest.param(mutant, id=name, marks=SLOWER.get(name, ()))


@pytest.mark.parametrize("mutant", [place(each) for each in PLACES])
def test_requirement_8_is_found_false_and_drawn(mutant: Mutant, tmp_path: Path) -> None:
    finding = refuted(mutant)
    assert told_run(finding)[-1].endswith("fell must be false, but it is true.")
    run = counterexample_run(finding, RunInfo())
    assert run is not None
    log, info = run
    assert info.violated == finding.sentence
    assert log.rows[-1].end_effector.name == "GRIPPED"
    figure = draw_run(log, info, tmp_path / "held.svg").read_text(encoding="utf-8")
    assert "VIOLATED" in figure


@pytest.mark.parametrize(
    "old",
    [
        "will = in_doubt() || session == NONE ? 0 : of_active(kept_will);",
        "todo = in_doubt() || kept_session != ENDED ? 0 : of_active(kept_will);",
    ],
)
def test_a_last_will_that_the_next_arbiter_forgets_is_noticed(old: str) -> None:
    """Nothing falls then: requirement 8 alone does not see it."""
    mutant = {"template": "Arbiter", "code": True, "old": old, "new": ""}
    network = make_network(read_document(mutated(TEXT, mutant).encode(), "deaths.xml"), {})
    resumed = next(each for each in requirements_of(network) if each.id == "will-resumed")
    assert not Explorer(network).check(resumed.query).holds


@pytest.mark.thinned
def test_the_shipped_tool_starts_from_any_lines() -> None:
    """The induction: whatever set of lines the deaths before have left, the next program may start from it."""
    tool = load(profile_path())
    automata = tool.automata
    network = load_network(tool.automata_path, {**model_constants(tool), "MIXED": True})
    assert prove(network, executed=automata.executed).holds
