"""A kind of device that this product does not know: refused before it is installed, and whole afterwards."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from .conftest import Environment

pytestmark = [pytest.mark.wall, pytest.mark.thinned, pytest.mark.timeout(300)]
TOOL = "examples/kinds/jaw/end_effector.yaml"


@pytest.fixture(scope="module")
def before(fresh: Environment) -> str:
    """What `eehal check` says before the jaw is installed."""
    return fresh.run("eehal", "check", TOOL, expected=2).stderr


@pytest.fixture(scope="module")
def installed(fresh: Environment, before: str) -> Environment:
    fresh.run("uv", "pip", "install", "--no-deps", "./examples/kinds/jaw")
    return fresh


@pytest.fixture(scope="module")
def recording(installed: Environment) -> Path:
    """The paper's first scenario, with the jaw."""
    installed.run("eehal", "demo", TOOL, "--no-ros", "--only", "nominal", "-o", "runs")
    return installed.folder / "runs" / "nominal"


def test_an_unknown_kind_is_refused_with_the_known_ones(before: str) -> None:
    assert "unknown kind of actuator (jaw), expected vacuum or cylinder or gripper or magnet" in before


def test_it_does_what_every_kind_must_do(installed: Environment) -> None:
    installed.run("python", "-m", "pytest", "-q", "-p", "no:cacheprovider", "./examples/kinds/jaw")


def test_it_is_checked(installed: Environment) -> None:
    done = installed.run("eehal", "check", TOOL)
    assert [line.split()[:3] for line in done.stdout.splitlines() if line.startswith("jaw  ")] == [
        ["jaw", "jaw", "GPIO17"]
    ]
    text = (installed.folder / TOOL).read_text(encoding="utf-8").replace("kind: jaw", "kind: jaws")
    (installed.folder / "misspelt.yaml").write_text(text, encoding="utf-8")
    assert "expected vacuum or cylinder or gripper or magnet or jaw; did you mean 'jaw'?" in (
        installed.run("eehal", "check", "misspelt.yaml", expected=2).stderr
    )


def test_its_keys_are_in_the_schema(installed: Environment) -> None:
    schema = json.loads(installed.run("eehal", "schema").stdout)
    assert schema["$defs"]["JawActuator"]["properties"]["closed_bit"]["default"] == "jaw_closed"


def test_its_automata_are_proved(installed: Environment) -> None:
    proof = json.loads(installed.run("eehal", "verify", TOOL, "--json").stdout)
    assert proof["requirements"]
    assert all(each["holds"] for each in proof["requirements"])


def test_it_grips_and_the_recording_is_told_in_its_words(recording: Path, installed: Environment) -> None:
    assert json.loads((recording / "run.json").read_text("utf-8"))["actuators"] == {"jaw": "jaw"}
    table = [row.split(",")[1:] for row in (recording / "states.csv").read_text("utf-8").splitlines()]
    assert table[0] == ["end_effector", "command", "jaw"]
    jaw = [int(row[-1]) for row in table[1:]]
    assert list(dict.fromkeys(jaw)) == [0, 1, 2]
    assert jaw[-1] == 0
    figure = (recording / "timeline.svg").read_text("utf-8")
    assert all(f">{word}<" in figure for word in ("OPEN", "PENDING CLOSE", "CLOSED"))
    told = json.loads(installed.run("eehal", "plot", "runs/nominal", "-o", "again.svg", "--json").stdout)
    assert told["verdict"] == "Nominal: GRIPPED, then dropped"


def test_its_recording_is_refused_where_it_is_not_installed(recording: Path, installed: Environment) -> None:
    installed.run("uv", "pip", "uninstall", "eehal-jaw")
    said = installed.run("eehal", "plot", "runs/nominal", "-o", "again.svg", expected=2).stderr
    assert "There is no kind of actuator 'jaw'. There are: vacuum, cylinder, gripper, magnet." in said
