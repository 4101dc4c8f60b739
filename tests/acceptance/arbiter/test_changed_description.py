"""A description that changes while a part is held: no line is forgotten, and none gets another role."""

from __future__ import annotations

import json
import signal
import subprocess
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from end_effector_hal.description import load, profile_path
from end_effector_hal.wires.lines import read_chip
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL

pytestmark = [pytest.mark.wall, pytest.mark.timeout(300)]
TOP, UNLOCK = "SODIMM_212", "SODIMM_206"


def eehal(*arguments: str) -> tuple[int, str]:
    done = subprocess.run([*EEHAL, *arguments], capture_output=True, text=True, check=False, timeout=120)
    return done.returncode, done.stdout + done.stderr


def without_top(tool: dict) -> None:
    del tool["actuators"]["top_vacuum"]
    tool["sequence"].remove("top_vacuum")


def exchanged(tool: dict) -> None:
    tool["tool_changer"]["line"], tool["actuators"]["top_vacuum"]["line"] = TOP, UNLOCK


def renamed(tool: dict) -> None:
    """Without `lines: socket` its arbiter has another socket, too; here its record has another name."""
    tool["lines"]["socket"] += ".renamed"
    without_top(tool)


def test_it_is_refused_until_the_part_is_dropped(tmp_path: Path) -> None:
    yaml = YAML(typ="safe", pure=True)
    with World(load(profile_path()), "nominal", tmp_path) as world:
        path = world.description_path
        former = path.read_text()

        def arbiter() -> None:
            world.arbiter = world.children.start(
                "line arbiter", [*EEHAL, "arbiter", str(path)], log=tmp_path / "log"
            )
            world.arbiter.wait_until(world.socket.exists, timeout_s=60, what="its socket")

        code, said = eehal("run", str(path), "--script", "lock; grip")
        assert code == 0, said
        held = read_chip(world.chip).lines
        assert held[TOP].level
        for change, number, sentence in (
            (without_top, signal.SIGTERM, f"{TOP} was top_vacuum (vacuum) on {world.chip} and is no output"),
            (exchanged, signal.SIGKILL, f"{TOP} was top_vacuum (vacuum) on {world.chip} and is unlock on"),
            (renamed, signal.SIGTERM, f"{TOP} was top_vacuum (vacuum) on {world.chip} and is no output"),
        ):
            world.arbiter.end(signal_number=number)
            world.socket.unlink(missing_ok=True)
            tool = yaml.load(former)
            change(tool)
            with path.open("w") as file:
                yaml.dump(tool, file)
            code, said = eehal("arbiter", str(path))
            assert (code, "Traceback" in said) == (2, False), said
            assert sentence in said
            assert "Drop first" in said
            code, said = eehal("doctor", "--json", "--only", "lines,arbiter", str(path))
            assert code == 3
            findings = " ".join(each["what"] for each in json.loads(said)["findings"])
            assert sentence in findings
            assert read_chip(world.chip).lines == held
            path.write_text(former)
            arbiter()
        code, said = eehal("run", str(path), "--script", "drop")
        assert code == 0, said
        assert not any(line.level for line in read_chip(world.chip).lines.values())
        world.arbiter.end()
        world.socket.unlink(missing_ok=True)
        tool = yaml.load(former)
        without_top(tool)
        with path.open("w") as file:
            yaml.dump(tool, file)
        arbiter()
        code, said = eehal("run", str(path), "--script", "unlock; lock; grip; drop")
        assert code == 0, said
