"""What the doctor says of the line arbiter."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from click.testing import CliRunner

from end_effector_hal.arbiter import ArbiterServer
from end_effector_hal.cli import _check
from end_effector_hal.cli.doctor import _arbiter
from end_effector_hal.codecs import load_tool
from end_effector_hal.errors import LineBusyError
from end_effector_hal.wires.link import PtyPair
from end_effector_lab.processes import EEHAL
from end_effector_lab.testbench import write_virtual_copy
from tests.support.places import ROOT
from tests.support.proving import proving
from tests.support.stopped import stop
from tests.support.stranger import as_nobody
from tests.unit.cli.doctor.conftest import LINES, Machine, serving


def test_an_arbiter_and_its_clients(machine: Machine, arbiter: ArbiterServer) -> None:
    from end_effector_hal.arbiter import ArbiterClient

    proven = proving(machine.socket, locked=True, nothing_gripped=False, parked=True)
    machine.findings("arbiter")  # the first look takes longer than what is said counts
    with ArbiterClient(machine.socket, "grip", ["SODIMM_208"]) as client, proven:
        client.set({"SODIMM_208": True}, will=[("SODIMM_208", False, 0)])
        assert machine.findings("arbiter") == [
            (
                "ok",
                f"pid {os.getpid()} serves {machine.socket}; writing: grip (pid {os.getpid()})",
                "",
            ),
            ("ok", "active: SODIMM_208 (bottom_vacuum)", ""),
            ("ok", "by the sensors: locked yes, nothing_gripped no, parked yes", ""),
        ]
        assert client.levels()["SODIMM_208"], "a look is not a death"


def test_a_description_is_refused_in_the_place_of_one_that_runs_with_an_active_line(
    machine: Machine, arbiter: ArbiterServer
) -> None:
    from end_effector_hal.arbiter import ArbiterClient

    def check() -> None:
        options = [str(machine.path), "--instead-of", str(machine.path)]
        CliRunner().invoke(_check.command, options, catch_exceptions=False)

    check()
    proven = proving(machine.socket, locked=True, nothing_gripped=False, parked=True)
    with ArbiterClient(machine.socket, "grip", ["SODIMM_208"]) as client, proven:
        client.set({"SODIMM_208": True}, will=[("SODIMM_208", False, 0)])
        with pytest.raises(LineBusyError, match=r"a part may be held: SODIMM_208 \(bottom_vacuum\)"):
            check()
        client.set({"SODIMM_208": False}, will=[])
    check()


def test_an_arbiter_that_nobody_tells_of_the_sensors_and_its_faults(
    machine: Machine, arbiter: ArbiterServer
) -> None:
    from end_effector_hal.arbiter import ArbiterClient

    with ArbiterClient(machine.socket, "grip", ["SODIMM_208"]) as client:
        client.latch("sensor_fault", "IL-04: both bits are set.")
        told = machine.findings("arbiter")[2:]
    assert [level for level, _, _ in told] == ["warning", "warning"]
    assert (
        told[0][1]
        == "no process reports what the sensors show (locked, nothing_gripped, parked): activations are refused"
    )
    assert told[1][1] == "latched: IL-04: both bits are set."


def test_the_arbiter_of_another_tool(machine: Machine, arbiter: ArbiterServer) -> None:
    text = machine.path.read_text().replace("SODIMM_212", "SODIMM_216")
    machine.describe(text=text)
    level, what, todo = machine.finding("arbiter")
    assert (level, what) == (
        "missing",
        f"pid {os.getpid()} at {machine.socket} owns other lines: {', '.join(LINES)}",
    )
    assert "another description" in todo


def test_an_output_whose_position_is_not_known_is_one_of_the_tool(
    machine: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    jaw = load_tool(ROOT / "examples/tools/double_acting_jaw/end_effector.yaml")
    machine.path = write_virtual_copy(jaw, tmp_path)
    machine.socket = tmp_path / "arbiter.sock"
    monkeypatch.setattr(machine, "make_chip", lambda: None)
    with serving(machine):
        first, active, *_ = machine.findings("arbiter")
    assert first[:2] == ("ok", f"pid {os.getpid()} serves {machine.socket}; no program writes")
    assert active[:2] == ("ok", "active: no line; position not known: GPIO5 (jaw)")


@pytest.mark.wall
def test_an_arbiter_that_hangs_is_named(machine: Machine) -> None:
    machine.make_chip()
    with subprocess.Popen([*EEHAL, "arbiter", str(machine.path)], stdout=subprocess.PIPE) as process:
        assert process.stdout
        assert process.stdout.readline().startswith(b"ready:")
        try:
            stop(process.pid)
            level, what, todo = machine.finding("arbiter")
        finally:
            process.kill()
    assert level == "missing"
    assert what.startswith(f"{machine.socket} is held by pid {process.pid} (")
    assert what.endswith("): the line arbiter does not answer.")
    assert "adopts" in todo
    # a socket that a dead arbiter left behind
    assert machine.finding("arbiter")[:2] == ("missing", f"no line arbiter runs at {machine.socket}")


def test_an_arbiter_where_somebody_else_put_it(
    machine: Machine, arbiter: ArbiterServer, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:

    monkeypatch.setattr(_arbiter, "_FOLDERS", (tmp_path,))
    machine.describe(text=machine.path.read_text().replace(f"{machine.socket}", f"{tmp_path}/x/arbiter.sock"))
    assert machine.finding("arbiter") == (
        "missing",
        f"no line arbiter at {tmp_path}/x/arbiter.sock, but there is a socket at {machine.socket}",
        f"Set EEHAL_RUN_DIR={tmp_path}, like the arbiter.",
    )


STRANGER = """
import contextlib, io, sys
from end_effector_hal.cli.doctor._doctor import command
with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
    command(["/dev/stdin", *sys.argv[1:]])  # as root: whatever it takes to look is loaded by this
become_nobody(groups)
command(["/dev/stdin", *sys.argv[1:]])
"""


@pytest.mark.thinned
@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody else")
def test_a_stranger_is_told_which_group_he_needs() -> None:
    def told() -> list[tuple[str, str]]:
        # the description is open already: a stranger to the wires, not to the disk
        with machine.path.open() as description:
            result = as_nobody(STRANGER, "--json", "--only", "lines,arbiter,link", stdin=description)
        assert (result.returncode, result.stderr) == (3, "")
        return [(each["what"], each["todo"]) for each in json.loads(result.stdout)["findings"]]

    with TemporaryDirectory(dir="/tmp") as name:
        folder = Path(name)
        folder.chmod(0o711)
        machine = Machine(folder)
        with serving(machine), PtyPair(machine.port):
            lines, socket, port = told()
            assert lines[0].endswith("it may not be written")
            assert socket[0] == f"{machine.socket} may not be opened: permission denied"
            assert "group gpio" in socket[1]
            assert port[0] == f"{machine.port} may not be opened: permission denied"
            assert "group dialout" in port[1]
            folder.chmod(0o700)
            assert told()[1][0] == f"{folder} may not be entered: permission denied"
