"""What may pass between the executed processes and their environment."""

import pytest

from end_effector_hal.errors import ModelError, UsageError
from timed_automata import Execution

QUIET = "state A; init A;"


def sides(load, text, interface=()):
    return Execution(load(f"{text} system P, E;"), ["P"], interface)


@pytest.mark.parametrize(
    ("ours", "theirs", "name"),
    [
        ("assign a = 1", "guard a == 1", "a"),  # written here, read there
        ("guard a == 1", "assign a = 1", "a"),
        ("assign a = 1", "assign a = 2", "a"),
        ("assign set()", "guard a == 1", "a"),  # through a function
        ("guard list[a] == 1", "assign list[1] = 2", "list"),
        ("sync c[a]!", "assign a = 1", "a"),  # in the index of a channel
        ("guard x >= a", "assign a = 1", "a"),  # in a bound
        ("guard x >= 1", "assign x = 0", "x"),  # a clock
        ("assign x = 0", "guard x >= 1", "x"),
    ],
)
def test_a_shared_variable_must_be_interface(load, ours, theirs, name):
    text = f"""int a, list[3]; clock x; broadcast chan c[3]; void set() {{ a = 1; }}
        process P() {{ {QUIET} trans A -> A {{ {ours} }}; }} process E() {{ {QUIET} trans A -> A {{ {theirs} }}; }}"""
    with pytest.raises(ModelError, match=f"share '{name}' with the environment, but not as interface"):
        sides(load, text)
    if name != "x":
        sides(load, text, [name])


def test_what_only_one_side_touches_and_what_both_only_read_is_free(load):
    sides(
        load,
        f"""int a, b, both; clock x, y;
        process P() {{ {QUIET} trans A -> A {{ guard both == 1 && x > 1; assign a = 1, x = 0 }}; }}
        process E() {{ {QUIET} trans A -> A {{ guard both == 1 && y > 1; assign b = 1, y = 0 }}; }}""",
    )


def test_names_that_do_not_exist(load):
    text = f"int evidence; process P() {{ {QUIET} }} process E() {{ {QUIET} }}"
    with pytest.raises(
        UsageError, match=r"interface variable 'evidense' is not in the network\. Did you mean 'evidence'\?"
    ):
        sides(load, text, ["evidense"])


@pytest.mark.parametrize("direction", ["!", "?"])
def test_binary_channels_do_not_cross(load, direction):
    other = "?" if direction == "!" else "!"
    with pytest.raises(ModelError, match="Both ends of the binary channel 'c' must be executed"):
        sides(
            load,
            f"""chan c; process P() {{ {QUIET} trans A -> A {{ sync c{direction} }}; }}
            process E() {{ {QUIET} trans A -> A {{ sync c{other} }}; }}""",
        )
    with pytest.raises(ModelError, match="Both ends of the binary channel 'c' must be executed"):
        sides(
            load,
            f"""chan c; process P() {{ {QUIET} trans A -> A {{ sync c{direction} }}; }}
            process E() {{ {QUIET} }}""",
        )


def test_a_broadcast_channel_has_its_senders_on_one_side(load):
    with pytest.raises(ModelError, match="Both sides send on the broadcast channel 'c'"):
        sides(
            load,
            f"""broadcast chan c; process P() {{ {QUIET} trans A -> A {{ sync c! }}; }}
            process E() {{ {QUIET} trans A -> A {{ sync c! }}; }}""",
        )


def test_equality_on_a_clock_cannot_be_executed(load, pointed):
    text = "clock x; process {}() {{ state A; init A; trans A -> A {{ guard x == 3 && true }}; }} "
    with pytest.raises(ModelError, match="'x == 3' cannot be executed") as error:
        sides(load, text.format("P") + f"process E() {{ {QUIET} }}")
    assert pointed(error.value).startswith("x == 3")
    sides(load, text.format("E") + f"process P() {{ {QUIET} }}")  # the environment may


def test_invariants_about_data_cannot_be_executed(load):
    with pytest.raises(ModelError, match="an executed location whose invariant is about data"):
        sides(load, f"int a; process P() {{ state A {{ a == 0 }}; init A; }} process E() {{ {QUIET} }}")
