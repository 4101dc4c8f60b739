"""What the worlds of the shipped model leave out changes no state of the programs."""

from __future__ import annotations

from itertools import product

from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path
from timed_automata import load_network
from timed_automata.explore import overview
from timed_automata.queries import parse_query


def test_apart_reaches_every_state_of_grip_that_anything_reaches() -> None:
    """A will is computed from these: so deaths in APART are deaths in every state."""
    description = load(profile_path())
    network = load_network(description.automata_path, model_constants(description))
    states = list(product(range(7), (-1, 2, 3, 4), (0, 1), (0, 1), (0, 1)))
    asked = [
        f"E<> world == {world} && ee == {ee} && command == {command}"
        f" && valve[0] == {a} && valve[1] == {b} && valve[2] == {c} && world > 0"
        for world in ("ANYTHING", "APART")
        for ee, command, a, b, c in states
    ]
    answers = overview(network, [parse_query(text) for text in asked]).answers
    anything, apart = answers[: len(states)], answers[len(states) :]
    assert sum(bool(answer) for answer in anything) > 20
    assert [s for s, x, y in zip(states, anything, apart, strict=True) if x and not y] == []
