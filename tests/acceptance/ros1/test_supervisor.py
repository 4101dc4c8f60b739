"""Supervisor: a script, a prompt, and clean ends."""

from __future__ import annotations

import os
import pty
import signal
import time
from contextlib import suppress
from typing import Any

import pytest

from end_effector_hal.vocabulary import Command, EndEffectorState
from tests.support.stopped import stop

pytestmark = pytest.mark.ros
RUN = ("rosrun", "end_effector_hal", "supervisor")


@pytest.fixture
def commands(system: Any) -> Any:
    import rospy
    from end_effector_msgs.msg import SupervisorCommand

    seen: list[int] = []
    subscriber = rospy.Subscriber("supervisor_commands", SupervisorCommand, lambda m: seen.append(m.command))
    yield seen
    subscriber.unregister()


def test_a_script_is_played_and_each_command_is_published(system: Any, commands: list[int]) -> None:
    done = system.cli(*RUN, "_script:=lock; wait 0.5; grip; drop; quit")
    assert done.returncode == 0, done.stderr
    lines = [line for line in done.stdout.splitlines() if "SUCCEEDED" in line]
    assert [line.split(":")[0] for line in lines] == ["lock", "grip", "release"]
    assert "the end-effector is GRIPPED. [bottom_vacuum " in lines[1]
    assert commands[-4:] == [Command.LOCK, Command.GRIP, Command.RELEASE, Command.QUIT]


def test_a_script_is_not_played_again_by_the_next_supervisor(system: Any, commands: list[int]) -> None:
    assert system.cli(*RUN, "_script:=lock").returncode == 0
    del commands[:]
    done = system.cli(*RUN)
    assert done.returncode == 0
    assert commands == [Command.QUIT]


def test_commands_come_from_a_pipe_as_well(system: Any) -> None:
    done = system.cli(*RUN, typed="grip\n\nfly\ndrop\n")
    assert done.returncode == 0
    said = [line for line in done.stdout.splitlines() if "SUCCEEDED" in line or "fly" in line]
    assert [line.split(":")[0] for line in said] == ["grip", "'fly' is not a command. There are", "release"]


def test_a_script_in_which_something_fails_says_why_and_ends_with_1(system: Any) -> None:
    done = system.cli(*RUN, "_script:=drop; quit")
    assert done.returncode == 1
    assert done.stdout.splitlines()[-1].startswith("release: REJECTED. Nothing is held")


def test_a_grip_of_a_part_asks_for_it_and_is_published_with_it(system: Any) -> None:
    import rospy
    from end_effector_msgs.msg import SupervisorCommand

    seen: list[str] = []
    subscriber = rospy.Subscriber("supervisor_commands", SupervisorCommand, lambda m: seen.append(m.part))
    done = system.cli(*RUN, "_script:=grip lid; quit")
    subscriber.unregister()
    assert done.returncode == 1
    why = "There is no part 'lid'; the description has no `parts`."
    assert done.stdout.splitlines()[-1] == f"grip lid: REJECTED. {why}"
    assert seen == ["lid", ""]


def test_a_cancel_in_a_script(system: Any) -> None:
    system.world.choose("never-confirms:cylinder")
    done = system.cli(*RUN, "_script:=grip &; wait 1.5; cancel; quit")
    assert done.returncode == 1
    assert "grip: CANCELLED after" in done.stdout
    assert "the end-effector is STAND_BY. The grip was cancelled." in done.stdout


def test_a_halmain_that_is_killed_is_waited_for_and_the_goal_is_not_known(system: Any) -> None:
    system.world.choose("never-confirms:top_vacuum")
    supervisor = system.start("killed", *RUN, "_script:=grip; quit")
    system.until("the last step", lambda: list(system.state.outputs) == [True, True, True])
    os.kill(system.pid_of("/HALMain"), signal.SIGKILL)
    assert supervisor.wait_for_end(timeout_s=60.0) == 1
    assert "grip: UNREACHABLE. HALMain was restarted and has lost this goal: " in supervisor.text()
    system.world.choose("nominal")
    system.wait_for(EndEffectorState.STAND_BY)  # HALMain ran the tool: the line arbiter has unwound the grip


def test_a_halmain_that_hangs_is_waited_for_and_the_goal_is_given_up(system: Any) -> None:
    system.world.choose("never-confirms:top_vacuum")
    supervisor = system.start("patient", *RUN, "_script:=grip; quit")
    system.until("the last step", lambda: list(system.state.outputs) == [True, True, True])
    pid = system.pid_of("/HALMain")
    stop(pid)
    try:
        code = supervisor.wait_for_end(timeout_s=60.0)
    finally:
        os.kill(pid, signal.SIGCONT)
    assert code == 1
    assert "grip: HALMain is silent; waiting for it, 10 s at most …" in supervisor.text()
    assert "grip: UNREACHABLE. HALMain was silent for 10 s: " in supervisor.text()
    system.world.choose("nominal")
    system.wait_for(EndEffectorState.STAND_BY)  # HALMain ran the tool: the line arbiter has unwound the grip


def test_a_bad_script_is_a_sentence(system: Any) -> None:
    done = system.cli(*RUN, "_script:=lock; gripp")
    assert done.returncode == 2
    assert (
        done.stderr.strip().splitlines()[-1] == "supervisor: 'gripp' is not a command. Did you mean 'grip'?"
    )


class Terminal:
    """A supervisor at a terminal."""

    def __init__(self, system: Any) -> None:
        self._system = system
        env = {**system.world.children.env, **system.env, "TERM": "dumb"}
        pid, self._ours = pty.fork()
        if pid == 0:
            os.execvpe(RUN[0], RUN, env)
        os.set_blocking(self._ours, False)
        self.pid, self.text = pid, ""

    def type(self, text: str) -> None:
        os.write(self._ours, text.encode())

    def reads(self, text: str) -> bool:
        with suppress(OSError):
            self.text += os.read(self._ours, 65536).decode(errors="replace")
        return text in self.text

    def code(self) -> int:
        def ended() -> Any:
            self.reads("")
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            return [os.waitstatus_to_exitcode(status)] if pid else None

        return int(self._system.until("its end", ended)[0])


@pytest.fixture
def terminal(system: Any) -> Any:
    terminal = Terminal(system)
    system.until("the prompt", lambda: terminal.reads("> "))
    yield terminal
    with suppress(ProcessLookupError, ChildProcessError):
        os.kill(terminal.pid, signal.SIGKILL)
        os.waitpid(terminal.pid, 0)


def test_a_prompt_is_not_blocked_by_a_running_grip(system: Any, terminal: Terminal) -> None:
    system.world.choose("never-confirms:cylinder")
    terminal.type("grip\n")
    system.until("the cylinder", lambda: list(system.state.actuators) == [2, 1, 0])
    terminal.type("fly\n")
    system.until("a sentence", lambda: terminal.reads("'fly' is not a command."))
    terminal.type("cancel\n")
    system.until("the outcome", lambda: terminal.reads("grip: CANCELLED after"))
    terminal.type("quit\n")
    assert terminal.code() == 0
    assert "Traceback" not in terminal.text


def test_the_end_of_the_input_ends_the_supervisor_and_nothing_else(system: Any, terminal: Terminal) -> None:
    terminal.type("grip\n")
    system.until("the outcome", lambda: terminal.reads("grip: SUCCEEDED"))
    terminal.type("\x04")
    assert terminal.code() == 0
    time.sleep(0.5)
    assert system.state.state == EndEffectorState.GRIPPED
    assert "Traceback" not in terminal.text


def test_ctrl_c_ends_the_supervisor_and_nothing_else(system: Any, terminal: Terminal) -> None:
    terminal.type("grip\n")
    system.until("GRIPPING", lambda: system.state.state == EndEffectorState.GRIPPING)
    terminal.type("\x03")
    assert terminal.code() == 0
    system.wait_for(EndEffectorState.GRIPPED)
    assert "Traceback" not in terminal.text


def test_rosnode_kill_ends_a_supervisor_that_waits_for_input(system: Any, terminal: Terminal) -> None:
    assert system.cli("rosnode", "kill", "/Supervisor").returncode == 0
    assert terminal.code() == 0
    assert "Traceback" not in terminal.text


def test_without_its_actions_it_waits_with_a_message_and_gives_up(system: Any) -> None:
    lonely = system.lonely
    system.until("its end", lambda: lonely.code is not None)
    assert lonely.code == 3
    lines = lonely.text().strip().splitlines()
    assert lines[0].startswith(
        "waiting for the actions LockToolChanger, UnlockToolChanger, TriggerGrip, Drop"
    )
    assert lines[-1].startswith(
        "supervisor: The actions of HALMain did not come up within 30 s. Are the nodes running"
    )
