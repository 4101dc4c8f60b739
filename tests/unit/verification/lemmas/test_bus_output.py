"""The lemma of registers: it holds, whatever steps a command has; what the code does is a run of it; and each of its
mutants is found out."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._verify import command as verify
from end_effector_hal.errors import UsageError
from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.verification.lemmas import BUS_FILE
from end_effector_hal.verification.proof import prove
from end_effector_hal.wires.bus._output import BusOutput
from tests.support.nightly import first_of
from tests.unit.figures.layout_faults import layout_faults
from tests.unit.verification.lemmas.output_runs import (
    ACTIVATED,
    APART,
    PLAIN,
    TWO_COILS,
    model_text,
    random_output_run,
)
from tests.unit.verification.mutants.conftest import Mutant, Shipped
from timed_automata import load_document, load_network, make_network, read_document
from timed_automata.explore import Explorer

pytestmark = pytest.mark.timeout(900)
HERE, ROOT = Path(__file__).parent, Path(__file__).parents[4]
MUTANTS: list[Mutant] = tomllib.loads(HERE.joinpath("bus_output.toml").read_text(encoding="utf-8"))["mutant"]
PATTERNS = [
    {"ACTIVATION": activation, "VERIFY": verify, "SHAKE": shake, "RELEASES": releases}
    for shake in (0, 1, 2)
    for activation in (0, 1)
    for verify in (0, 1)
    for releases in (0, 1)
    if not (shake and activation)
]


@pytest.mark.parametrize("template", load_document(BUS_FILE).templates, ids=lambda each: each.name.content)
def test_it_reads_well(template) -> None:  # type: ignore[no-untyped-def]
    assert layout_faults(template) == []


@pytest.mark.parametrize("constants", first_of(PATTERNS, 2, 3), ids=str)
def test_all_of_it_holds(constants: dict[str, int]) -> None:
    found = prove(load_network(BUS_FILE, constants))
    assert [each.id for each in found.findings if not each.holds] == []


@pytest.mark.parametrize("seed", first_of(range(12), 2, 2))
def test_what_the_code_does_is_a_run_of_the_network(seed: int) -> None:
    assert random_output_run(PLAIN, seed).is_one_of(model_text())


@pytest.mark.parametrize("seed", first_of([1, 0, 2, 3, 4, 5], 1, 1))
def test_with_an_activation_it_is_one_too(seed: int) -> None:
    assert random_output_run(ACTIVATED, seed).is_one_of(model_text())


@pytest.mark.parametrize("seed", first_of(range(6), 1, 1))
def test_where_no_command_activates_it_is_one_too(seed: int) -> None:
    assert random_output_run(APART, seed).is_one_of(model_text())


@pytest.mark.parametrize("seed", first_of(range(12), 2, 2))
def test_with_two_coils_it_is_one_too(seed: int) -> None:
    assert random_output_run(TWO_COILS, seed).is_one_of(model_text())


@pytest.mark.parametrize("constants", first_of([{"VERIFY": 0}, {"VERIFY": 1, "RELEASES": 1}], 1), ids=str)
def test_all_of_it_holds_for_two_coils(constants: dict[str, int]) -> None:
    plain = {"ACTIVATION": 0, "SHAKE": 0, "RELEASES": 0, "PAIR": 1}
    found = prove(load_network(BUS_FILE, plain | constants))
    assert [each.id for each in found.findings if not each.holds] == []


def test_a_release_that_does_not_look_whether_the_device_is_active_would_activate_it() -> None:
    """As every release was written, of gripper_2f85 for one: its rows have rACT set."""
    text, old = model_text(), "level == 1 || CARRIES == 1) || drops &amp;&amp; PAIR == 0;"
    assert old in text
    text = text.replace(old, "level == 1) || drops &amp;&amp; PAIR == 0;")
    wrong = make_network(read_document(text.encode(), "old.xml"), {"ACTIVATION": 1, "VERIFY": 0})
    assert not Explorer(wrong).check("A[] !rash").holds


def _believes_every_acknowledgement(self: BusOutput, at: int) -> None:
    self._steps.clear()
    self._written_at = at


def _keeps_what_was_withdrawn(self: BusOutput, why: str) -> None:
    self.why = why


def _writes_what_it_has(self: BusOutput, at: int) -> None:
    self._steps.extend(self._told(level=False))


SEEDS = range(400)
"""Few runs write again what was lost."""


def _goes_on_where_it_was(self: BusOutput, at: int) -> None:
    self.retry_at = at + 100_000


@pytest.mark.parametrize(
    ("name", "wrong", "output"),
    [
        ("acknowledged", _believes_every_acknowledgement, PLAIN),
        pytest.param("_give_up", _keeps_what_was_withdrawn, PLAIN, marks=pytest.mark.thinned),
        ("acknowledge", _writes_what_it_has, PLAIN),
        ("failed", _goes_on_where_it_was, TWO_COILS),
    ],
)
def test_code_that_does_something_else_is_found_out(
    monkeypatch: pytest.MonkeyPatch, name: str, wrong: object, output: RegisterOutput
) -> None:
    right = [random_output_run(output, seed).steps for seed in SEEDS]
    monkeypatch.setattr(BusOutput, name, wrong)
    runs = [random_output_run(output, seed) for seed in SEEDS]
    others = [run for run, steps in zip(runs, right, strict=True) if run.steps != steps]
    assert not all(run.is_one_of(model_text()) for run in others)


@pytest.mark.parametrize("mutant", first_of(MUTANTS, 3), ids=[each["name"] for each in MUTANTS])
def test_the_mutant_is_caught(mutant: Mutant) -> None:
    shipped = Shipped(BUS_FILE.read_text(encoding="utf-8"), {"ACTIVATION": 0, "VERIFY": 0})
    assert shipped.catches(mutant), f"{mutant['name']}: survives"


@pytest.mark.thinned  # long
def test_eehal_verify_proves_it_for_an_actuator_on_a_bus() -> None:
    tool = str(ROOT / "examples" / "tools" / "area_gripper" / "end_effector.yaml")
    with pytest.raises(UsageError, match=r"'nothing' is not commanded over a bus"):
        CliRunner().invoke(verify, [tool, "--registers", "nothing"], catch_exceptions=False)
    tool = str(ROOT / "examples" / "tools" / "gripper_2f85" / "end_effector.yaml")
    result = CliRunner().invoke(verify, [tool, "--registers", "fingers"], catch_exceptions=False)
    assert result.exit_code == 0
    assert "hold" in result.stdout
