"""The Supervisor's script needs no ROS."""

from __future__ import annotations

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.runtime import ScriptCommand, read_command, read_script
from end_effector_hal.vocabulary import Command


def test_steps_are_separated_by_semicolons_or_line_ends() -> None:
    assert read_script("lock; grip ;wait 2.5\n\n RELEASE;; quit # the end; grip\n") == (
        ScriptCommand(Command.LOCK),
        ScriptCommand(Command.GRIP),
        ScriptCommand(wait_s=2.5),
        ScriptCommand(Command.RELEASE),
        ScriptCommand(Command.QUIT),
    )


def test_drop_is_the_release_of_table_ii() -> None:
    assert read_script("drop") == read_script("release") == (ScriptCommand(Command.RELEASE),)


def test_an_ampersand_sends_to_the_background() -> None:
    assert read_script("grip &; wait 1; cancel") == (
        ScriptCommand(Command.GRIP, background=True),
        ScriptCommand(wait_s=1.0),
        ScriptCommand(Command.CANCEL),
    )
    assert read_command("grip&") == ScriptCommand(Command.GRIP, background=True)


def test_an_empty_script_holds_nothing() -> None:
    assert read_script(" ;\n# nothing\n;") == ()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("lock; gripp; quit", "'gripp' is not a command. Did you mean 'grip'?"),
        ("fly", "'fly' is not a command. There are: "),
        ("grip 3", "'grip 3': nothing may follow 'grip'."),
        ("lock grip", "nothing may follow 'lock'. Separate commands by ';'."),
        ("grip & wait 3", "nothing may follow 'grip'. Separate commands by ';', also behind an '&'."),
        ("scenario ", "'scenario': expected is 'scenario <text>', for example 'scenario nominal'."),
        ("wait", "'wait': expected is 'wait <seconds>'"),
        ("wait soon", "expected is 'wait <seconds>'"),
        ("wait -1", "expected is 'wait <seconds>'"),
        ("wait nan", "expected is 'wait <seconds>'"),
        ("wait inf", "expected is 'wait <seconds>'"),
        ("wait 1 2", "expected is 'wait <seconds>'"),
        ("wait 1 &", "a wait cannot go on in the background"),
        ("&", "'&' is not a command."),
    ],
)
def test_what_is_no_script_is_said_in_a_sentence(text: str, expected: str) -> None:
    with pytest.raises(UsageError) as raised:
        read_script(text)
    assert expected in str(raised.value)


def test_a_scenario_is_for_the_testbench_as_it_was_typed() -> None:
    assert read_script("Scenario  leak:Cup_A:2, supply:300 ; grip") == (
        ScriptCommand(scenario="leak:Cup_A:2, supply:300"),
        ScriptCommand(Command.GRIP),
    )


def test_a_resume_and_a_reset_are_no_commands_of_table_ii() -> None:
    assert read_command("resume") == ScriptCommand(resume=True)
    assert read_command("reset") == ScriptCommand(reset=True)
    with pytest.raises(UsageError, match="Did you mean 'reset'"):
        read_command("rest")
