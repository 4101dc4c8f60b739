"""``eehal run --simulate``: a whole tool in one terminal, and nothing of it is left."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from tempfile import mkdtemp

import pytest

from end_effector_hal.description import profile_path
from end_effector_hal.recording import read_run
from end_effector_lab.processes import EEHAL
from tests.support.nightly import first_of
from tests.support.patience import wait_until
from tests.support.places import ROOT

pytestmark = [pytest.mark.wall, pytest.mark.timeout(100)]
LONG_S = 90.0
TWO_COILS = ROOT / "examples/tools/two_coil_changer/end_effector.yaml"


class Started:
    """The command, with the folder for everything temporary."""

    def __init__(self, *options: str, file: Path | None = None) -> None:
        self.temporary = Path(mkdtemp(prefix="simulated-", dir="/tmp"))  # a socket's path is short
        self.process = subprocess.Popen(
            [
                "env",
                "--default-signal=INT",
                *EEHAL,
                "run",
                "--simulate",
                str(file or profile_path()),
                *options,
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "TMPDIR": str(self.temporary)},
            start_new_session=True,
        )

    def read_until(self, pattern: str) -> None:
        assert self.process.stdout is not None
        said = []
        for line in self.process.stdout:
            said.append(line)
            if re.match(pattern, line):
                return
        raise AssertionError(f"{pattern!r} was not said: {said}")

    def others(self) -> list[str]:
        """Testbench and arbiter: they name the description in the temporary folder."""
        found = []
        for each in Path("/proc").glob("[0-9]*/cmdline"):
            try:
                words = each.read_bytes().decode(errors="replace").split("\0")
            except OSError:
                continue
            if any(str(self.temporary) in word for word in words):
                found.append(" ".join(words))
        return found


@pytest.fixture
def started(tmp_path: Path) -> Iterator[list[Started]]:
    all_of_them: list[Started] = []
    yield all_of_them
    for each in all_of_them:
        each.process.kill()
        each.process.communicate()
        shutil.rmtree(each.temporary, ignore_errors=True)


@pytest.mark.alone  # a testbench that is late for 150 ms has a grip refused, as it should
def test_a_script_from_an_empty_folder_to_the_end(started: list[Started], tmp_path: Path) -> None:
    tool = Started("--script", "lock; grip; drop", "--seed", "5", "--record", str(tmp_path / "recorded"))
    started.append(tool)
    out, err = tool.process.communicate(timeout=LONG_S)
    said, page = err.splitlines()
    assert (tool.process.returncode, said) == (
        0,
        "Simulated: virtual lines and a testbench; nothing real moves.",
    )
    assert re.fullmatch(r"While this runs, a page shows it: eehal page /\S+/end_effector\.yaml", page)
    assert [line for line in out.splitlines() if "succeeded" in line] == [
        "LOCK: succeeded",
        "GRIP: succeeded",
        "DROP: succeeded",
    ]
    assert (tool.others(), list(tool.temporary.iterdir())) == ([], [])
    assert (tmp_path / "recorded" / "states.csv").exists()
    run = read_run(tmp_path / "recorded")
    assert (run.scenario, run.seed, run.simulated) == ("nominal", 5, True)


@pytest.mark.alone  # as above
def test_what_goes_wrong_is_chosen_at_the_start_and_while_it_runs(started: list[Started]) -> None:
    script = "lock; wait 1; grip; scenario leek:cylinder; scenario nominal; wait 1; grip; drop"
    tool = Started("--scenario", "supply:300", "--script", script)
    started.append(tool)
    out, _ = tool.process.communicate(timeout=LONG_S)
    told = re.compile("refused|scenario: |[A-Z]+: succeeded")
    grip, leek, *rest = [line for line in out.splitlines() if told.match(line)][1:]
    assert grip.startswith("refused: grip. IL-06")
    assert leek == "refused: scenario. no fault is named 'leek'. Did you mean 'leak'?"
    assert rest == ["scenario: nominal", "GRIP: succeeded", "DROP: succeeded"]
    assert tool.process.returncode == 1


@pytest.mark.alone  # as above
@pytest.mark.parametrize(
    ("file", "bit"),
    [
        pytest.param(profile_path(), "tool_present", id="shipped"),
        pytest.param(TWO_COILS, "coupled", id="two_coils", marks=pytest.mark.thinned),
    ],
)
def test_without_a_tool_nothing_is_locked_or_gripped_and_no_lift_is_allowed(
    started: list[Started], file: Path, bit: str
) -> None:
    script = (
        "wait 1; lock; grip; scenario nominal; wait 1; grip; status; scenario no-tool; wait 1; status; drop"
    )
    tool = Started("--scenario", "no-tool", "--script", script, file=file)
    started.append(tool)
    out, _ = tool.process.communicate(timeout=LONG_S)
    told = re.compile("refused|[A-Z]+: succeeded")
    assert [line for line in out.splitlines() if told.match(line)] == [
        f"refused: lock. A lock is refused: there is no tool ({bit} is off).",
        f"refused: grip. IL-05: there is no tool ({bit} is off).",
        "GRIP: succeeded",
        "DROP: succeeded",
    ]
    held, gone = out.split("scenario: no-tool")
    assert "GRIPPED; a part is held, lift allowed" in held
    assert f"IL-05: there is no tool ({bit} is off) while a part is held: do not lift" in gone
    assert "GRIPPED; a part is held, lift not allowed" in gone


@pytest.mark.alone  # as above
def test_a_grip_right_after_the_reset_of_a_stop(started: list[Started]) -> None:
    tool = Started("--script", "lock; grip; stop; drop; grip; reset; grip; drop")
    started.append(tool)
    out, _ = tool.process.communicate(timeout=LONG_S)
    told = re.compile("refused|[A-Z]+: succeeded")
    said = [line for line in out.splitlines() if told.match(line)]
    refused = said.pop(4)
    assert refused.startswith("refused: grip. IL-13: the tool was stopped")
    assert [line.partition(":")[0] for line in said] == [
        "LOCK", "GRIP", "STOP", "DROP", "RESET", "GRIP", "DROP",
    ]  # fmt: skip
    assert tool.process.returncode == 1


@pytest.mark.nightly  # a stop from another terminal has a prompt, too
def test_commands_come_from_the_prompt(started: list[Started]) -> None:
    tool = Started()
    started.append(tool)
    out, _ = tool.process.communicate("lock\nquit\n", timeout=LONG_S)
    assert (tool.process.returncode, "LOCK: succeeded" in out) == (0, True)


@pytest.mark.parametrize("number", first_of([signal.SIGINT, signal.SIGTERM, signal.SIGHUP], 1, 1))
def test_a_signal_leaves_no_process_and_no_file(number: signal.Signals, started: list[Started]) -> None:
    tool = Started("--script", "lock; grip; wait 600")
    started.append(tool)
    tool.read_until("GRIP: |refused: grip")  # whether it succeeds on a busy machine is not asked here
    assert len(tool.others()) == 2
    # as a terminal does it: to the whole group, and by somebody who is impatient
    for _ in range(2):
        os.killpg(tool.process.pid, number)
    tool.process.communicate(timeout=LONG_S)
    assert tool.process.returncode == (130 if number is signal.SIGINT else 128 + number)
    assert (tool.others(), list(tool.temporary.iterdir())) == ([], [])


def test_who_is_killed_leaves_no_process(started: list[Started]) -> None:
    tool = Started("--script", "lock; wait 600")
    started.append(tool)
    tool.read_until("LOCK: ")
    tool.process.kill()
    wait_until("testbench and arbiter end", lambda: tool.others() == [])


def test_a_signal_while_it_starts(started: list[Started]) -> None:
    tool = Started()
    started.append(tool)
    wait_until("the testbench is started", lambda: tool.others() != [])
    tool.process.send_signal(signal.SIGTERM)
    tool.process.communicate(timeout=LONG_S)
    assert tool.process.returncode == 128 + signal.SIGTERM
    assert (tool.others(), list(tool.temporary.iterdir())) == ([], [])


def test_a_stop_from_another_terminal_cancels_a_grip_and_stays_until_a_reset(started: list[Started]) -> None:
    """The line arbiter keeps the stop: any process that may command it may stop the tool."""
    tool = Started("--scenario", "never-confirms:cylinder")
    started.append(tool)
    assert tool.process.stdin is not None
    tool.process.stdin.write("lock\ngrip\ngrip\nreload\nreset\nquit\n")
    tool.process.stdin.flush()
    tool.read_until("GRIPPING: Bottom vacuum ON, Cylinder PENDING EXTEND")
    (description,) = tool.temporary.glob("eehal-run-*/end_effector.yaml")

    def asked(word: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([*EEHAL, word, str(description)], capture_output=True, text=True, check=False)

    stopped = asked("stop")
    assert stopped.returncode == 0, stopped.stderr
    assert "This is no safety function." in stopped.stdout
    tool.read_until("GRIPPING -> RELEASING.*cancelled")
    tool.read_until("GRIP: cancelled")
    tool.read_until(r"refused: grip. IL-13: the tool was stopped \(pid [0-9]+, .* stop ")
    tool.read_until(
        "refused: reload. A simulated line arbiter forgets its faults in a reload: reset them first. IL-13"
    )
    tool.read_until("RESET: succeeded")
    tool.process.wait(20)
    unreachable = asked("stop")
    assert unreachable.returncode == 3 or "no such file" in unreachable.stderr.lower(), unreachable.stderr
