"""The line arbiter and its template in the UPPAAL file are held together: what the one does is a run of the other."""

from __future__ import annotations

from dataclasses import replace

import pytest

from end_effector_hal.arbiter import LineArbiter, Policy, arbiter_policy
from end_effector_hal.description import Description, load, profile_path
from tests.support.blown import TOP_AIR, blown
from tests.support.declared import declared
from tests.support.nightly import first_of
from tests.unit.arbiter.template_runs import random_run

SEEDS = range(24)


@pytest.fixture(scope="module")
def description() -> Description:
    return load(profile_path())


@pytest.fixture(scope="module")
def text(description: Description) -> str:
    return description.automata_path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def policy(description: Description) -> Policy:
    """The arbiter's, without what no line shows: sensors, and the time that a line takes to settle (IL-10)."""
    return replace(arbiter_policy(description), needs={}, min_switch_us=0)


@pytest.mark.parametrize("seed", first_of(SEEDS, 2, 2))
def test_what_the_line_arbiter_does_is_a_run_of_its_template(
    description: Description, text: str, policy: Policy, seed: int
) -> None:
    assert random_run(description, policy, seed).is_one_of(text)


MIXED = {
    "dies mixed": declared(
        bottom_vacuum={"gripping": {"process_death": "hold"}},
        cylinder={"gripping": {"process_death": "leave"}, "held": {"process_death": "leave"}},
    ),
    "drops the middle": declared(il_09=False, cylinder={"held": {"process_death": "release"}}),
    "unlock stays": declared(changer={"process_death": "hold"}),
}


@pytest.mark.parametrize("seed", first_of(range(8), 1, 1))
@pytest.mark.parametrize("mixed", MIXED)
def test_so_it_is_with_endings_of_each_actuator(text: str, policy: Policy, mixed: str, seed: int) -> None:
    assert random_run(MIXED[mixed], policy, seed).is_one_of(text)


@pytest.mark.parametrize("mixed", MIXED)
def test_other_endings_than_the_declared_ones_are_found_out(
    description: Description, text: str, policy: Policy, mixed: str
) -> None:
    """The wills are those of one description, the template has the constants of another."""
    runs = [random_run(MIXED[mixed], policy, seed) for seed in SEEDS]
    assert not all(replace(run, description=description).is_one_of(text) for run in runs)


@pytest.fixture(scope="module")
def one_blown() -> Description:
    """Of two the template remembers the gap of the last alone: the automata blow one off at a time."""
    tool = blown()
    bottom = tool.actuators["bottom_vacuum"].model_copy(update={"blow_off": None})
    return tool.model_copy(update={"actuators": {**tool.actuators, "bottom_vacuum": bottom}})


def policy_of(description: Description) -> Policy:
    return replace(arbiter_policy(description), needs={}, min_switch_us=0)


@pytest.mark.parametrize("seed", first_of(SEEDS, 2, 2))
def test_so_it_is_with_a_blow_off(one_blown: Description, text: str, seed: int) -> None:
    assert random_run(one_blown, policy_of(one_blown), seed).is_one_of(text)


class Breathless(LineArbiter):
    """Forgets to end a blow-off in a will."""

    def declare_dead(self, session, why, at):  # type: ignore[no-untyped-def]
        session.will = tuple(step for step in session.will if step.line != TOP_AIR)
        super().declare_dead(session, why, at)


@pytest.mark.parametrize("wrong", first_of(["bound", "exclusions", "will"], 2))
def test_another_line_arbiter_is_found_out_by_what_it_blows(
    one_blown: Description, text: str, wrong: str
) -> None:
    policy = policy_of(one_blown)
    if wrong == "bound":
        policy = replace(policy, max_active_us={})
    elif wrong == "exclusions":
        policy = replace(policy, exclusions=[each for each in policy.exclusions if "IL-08" not in each])
    rules = Breathless if wrong == "will" else LineArbiter
    assert not all(random_run(one_blown, policy, seed, rules).is_one_of(text) for seed in SEEDS)


class Backwards(LineArbiter):
    """Does wills from their end."""

    def declare_dead(self, session, why, at):  # type: ignore[no-untyped-def]
        lines = [step.line for step in reversed(session.will)]
        steps = zip(session.will, lines, strict=True)
        session.will = tuple(step._replace(line=line) for step, line in steps)
        super().declare_dead(session, why, at)


class Hasty(LineArbiter):
    """Does wills without waiting."""

    def declare_dead(self, session, why, at):  # type: ignore[no-untyped-def]
        session.will = tuple(step._replace(after_us=0) for step in session.will)
        super().declare_dead(session, why, at)


class Careless(LineArbiter):
    """Forgets wills."""

    def declare_dead(self, session, why, at):  # type: ignore[no-untyped-def]
        session.will = ()
        super().declare_dead(session, why, at)


@pytest.mark.parametrize("wrong", [Backwards, Hasty, Careless])
def test_another_line_arbiter_is_found_out(
    description: Description, text: str, policy: Policy, wrong: type[LineArbiter]
) -> None:
    assert not all(random_run(description, policy, seed, wrong).is_one_of(text) for seed in SEEDS)


@pytest.mark.parametrize("change", [{"exclusions": ()}, {"max_active_us": {}}])
def test_a_line_arbiter_with_fewer_rules_is_found_out(
    description: Description, text: str, policy: Policy, change: dict
) -> None:
    fewer = replace(policy, **change)
    assert not all(random_run(description, fewer, seed).is_one_of(text) for seed in SEEDS)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("RELEASE_ORDER[m &lt; N ? m : N - 1]", "RELEASE_ORDER[m &lt; N ? N - 1 - m : 0]"),
        ("return HELD_DEATH_KEEPS[j]", "return DEATH_KEEPS[j]"),
        ("v &gt;= T_UNLOCK", "v &gt;= T_UNLOCK + 1000"),
    ],
)
def test_another_template_is_found_out(
    description: Description, text: str, policy: Policy, old: str, new: str
) -> None:
    assert old in text
    changed = text.replace(old, new).replace("v &lt;= UNLOCK_BOUND", "v &lt;= UNLOCK_BOUND + 2000")
    assert not all(random_run(description, policy, seed).is_one_of(changed) for seed in SEEDS)
