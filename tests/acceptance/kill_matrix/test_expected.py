"""The declared endings, spelled out for the shipped tool."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.vocabulary import EndEffectorState as State
from tests.acceptance.kill_matrix.cells import PROCESSES, SIGNALS, Cell, full, gripping, states, telling
from tests.acceptance.kill_matrix.expected import expected
from tests.support.declared import declared
from tests.support.places import ROOT

UNLOCK, BOTTOM, CYLINDER, TOP = "SODIMM_206", "SODIMM_208", "SODIMM_210", "SODIMM_212"


@pytest.fixture(scope="module")
def description() -> Description:
    return load(profile_path())


@pytest.mark.parametrize(
    ("cell", "state", "moved", "active"),
    [
        ("HALMain:SIGKILL:STAND_BY", State.STAND_BY, [], []),
        ("HALMain:SIGKILL:GRIPPING cylinder", State.STAND_BY, [(CYLINDER, False), (BOTTOM, False)], []),
        ("HALMain:SIGSTOP:GRIPPING bottom_vacuum", State.STAND_BY, [(BOTTOM, False)], []),
        ("HALMain:SIGTERM:GRIPPED", State.GRIPPED, [], [BOTTOM, CYLINDER, TOP]),
        ("HALMain:SIGKILL:RELEASING", State.STAND_BY, [(CYLINDER, False), (BOTTOM, False)], []),
        ("Grip:SIGKILL:GRIPPING cylinder", State.GRIPPED, [(TOP, True)], [BOTTOM, CYLINDER, TOP]),
        ("LineArbiter:SIGKILL:GRIPPING top_vacuum", State.GRIPPED, [], [BOTTOM, CYLINDER, TOP]),
        ("LineArbiter:SIGSTOP:GRIPPING bottom_vacuum", State.STAND_BY, [(BOTTOM, False)], []),
        ("roscore:SIGKILL:GRIPPING bottom_vacuum", State.STAND_BY, [(BOTTOM, False)], []),
        ("HALMain:SIGKILL:unlocking", State.STAND_BY, [(UNLOCK, False)], []),
        ("Pressure:SIGSTOP:GRIPPED", State.GRIPPED, [], [BOTTOM, CYLINDER, TOP]),
        ("ToolChange:SIGKILL:GRIPPING cylinder", State.GRIPPED, [(TOP, True)], [BOTTOM, CYLINDER, TOP]),
        ("HAL:SIGKILL:GRIPPED", State.GRIPPED, [], [BOTTOM, CYLINDER, TOP]),
        ("HAL:SIGSTOP:GRIPPING bottom_vacuum", State.STAND_BY, [(BOTTOM, False)], []),
        ("HAL:SIGKILL:unlocking", State.STAND_BY, [(UNLOCK, False)], []),
        ("HAL and LineArbiter:SIGKILL:GRIPPED", State.GRIPPED, [], [BOTTOM, CYLINDER, TOP]),
        ("HAL and LineArbiter:SIGKILL:GRIPPING bottom_vacuum", State.STAND_BY, [(BOTTOM, False)], []),
        ("HAL and LineArbiter:SIGKILL:RELEASING", State.STAND_BY, [(CYLINDER, False), (BOTTOM, False)], []),
    ],
)
def test_endings(description: Description, cell: str, state: State, moved: list, active: list) -> None:
    want = expected(description, Cell(*cell.split(":")))
    assert want.states == {state}
    assert [*want.unlock, *want.gripping] == moved
    assert want.active == set(active)


def test_a_release_that_ends_without_a_line_arbiter_keeps_the_rest(description: Description) -> None:
    want = expected(description, Cell("LineArbiter", "SIGKILL", "RELEASING"))
    assert want.may_keep
    kept = want.kept(1)
    assert (kept.gripping, kept.active) == (((CYLINDER, False),), {BOTTOM})
    assert kept.states == {State.GRIP_ERROR}
    assert not expected(description, Cell("HALMain", "SIGKILL", "RELEASING")).may_keep


def test_what_is_declared_is_expected(description: Description) -> None:
    endings = description.endings.gripping.model_copy(update={"process_death": "hold"})
    other = description.model_copy(
        update={"endings": description.endings.model_copy(update={"gripping": endings})}
    )
    want = expected(other, Cell("HALMain", "SIGKILL", "GRIPPING cylinder"))
    assert (want.gripping, want.active, want.states) == ((), {BOTTOM, CYLINDER}, {State.GRIP_ERROR})
    assert expected(other, Cell("HALMain", "SIGTERM", "GRIPPING cylinder")).states == {State.STAND_BY}


def test_each_actuator_has_its_own_ending() -> None:
    other = declared(
        {"gripping": {"sigterm": "leave"}},
        il_09=False,
        bottom_vacuum={"gripping": {"process_death": "hold"}, "power_up": "release"},
        cylinder={"held": {"process_death": "release"}},
    )
    dies = expected(other, Cell("HALMain", "SIGKILL", "GRIPPING top_vacuum"))
    assert [line for line, _ in dies.gripping] == [TOP, CYLINDER, BOTTOM]
    assert (dies.states, dies.active) == ({State.STAND_BY}, set())
    held = expected(other, Cell("HALMain", "SIGKILL", "GRIPPED"))
    assert [line for line, _ in held.gripping] == [CYLINDER, BOTTOM]
    assert (held.states, held.active) == ({State.GRIP_ERROR}, {TOP})
    told = expected(other, Cell("HALMain", "SIGTERM", "GRIPPING cylinder"))
    assert (told.gripping, told.first_s, told.states) == (((BOTTOM, False),), None, {State.GRIP_ERROR})


@pytest.mark.parametrize(
    ("cell", "state", "moved", "active"),
    [
        ("HALMain:SIGKILL:GRIPPING cylinder", State.GRIP_ERROR, [CYLINDER], [BOTTOM]),
        ("HALMain:SIGTERM:GRIPPING cylinder", State.GRIP_ERROR, [], [BOTTOM, CYLINDER]),
        ("HALMain:SIGTERM:GRIPPING top_vacuum", State.GRIP_ERROR, [TOP], [BOTTOM, CYLINDER]),
        ("HALMain:SIGSTOP:GRIPPED", State.GRIP_ERROR, [CYLINDER, TOP], [BOTTOM]),
        ("HALMain:SIGTERM:GRIPPED", State.GRIP_ERROR, [TOP], [BOTTOM, CYLINDER]),
        ("LineArbiter:SIGKILL:GRIPPED", State.GRIPPED, [], [BOTTOM, CYLINDER, TOP]),
        ("HALMain:SIGKILL:unlocking", State.STAND_BY, [UNLOCK], []),
    ],
)
def test_mixed_endings(cell: str, state: State, moved: list[str], active: list[str]) -> None:
    """Of the description that the matrix is played with by hand."""
    mixed = load(Path(__file__).with_name("mixed_endings.yaml"))
    want = expected(mixed, Cell(*cell.split(":")))
    assert (want.states, want.active) == ({state}, set(active))
    assert [*want.unlock, *want.gripping] == [(line, False) for line in moved]


def test_what_is_held_whole_may_be_confirmed_by_the_next_start() -> None:
    holds = declared({"gripping": {"process_death": "hold"}})
    want = expected(holds, Cell("HALMain", "SIGKILL", "GRIPPING top_vacuum"))
    assert want.states == {State.GRIPPED, State.GRIP_ERROR}
    assert want.gripping == ()


def test_a_part_has_the_cells_and_the_endings_of_its_own_actuators() -> None:
    whole = load_tool(ROOT / "examples/cells/three_parts/end_effector.yaml")
    sheet = gripping(whole, "sheet")
    assert [each for each in states(sheet) if each.startswith("GRIPPING")] == [
        "GRIPPING left",
        "GRIPPING right",
    ]
    want = expected(sheet, Cell("HAL", "SIGKILL", "GRIPPED"))
    assert want.active == {whole.actuators[name].line for name in ("left", "right")}
    fingers = gripping(whole, "bracket")
    assert [each for each in states(fingers) if each.startswith("GRIPPING")] == ["GRIPPING fingers"]
    assert gripping(whole, "crate").actuators["left"].timeout_s == 6
    assert gripping(whole, "") is whole


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--part", "lid"], "There are: none."),
        (["nobody"], "No cell is nobody."),
        (["--description", "changerless.yaml"], "it takes a tool with a tool changer"),
        (["--description", "none.yaml"], "none.yaml"),
    ],
)
def test_what_cannot_be_played_is_a_sentence(tmp_path: Path, arguments: list[str], said: str) -> None:
    text = Path(__file__).with_name("mixed_endings.yaml").read_text()
    changer = text.index("tool_changer:")
    (tmp_path / "changerless.yaml").write_text(text[:changer] + text[text.index("interlocks:") :])
    arguments = [str(tmp_path / word) if word.endswith(".yaml") else word for word in arguments]
    program = [sys.executable, "-m", "tests.acceptance.kill_matrix.run", *arguments]
    run = subprocess.run(program, cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 2
    assert said in run.stderr
    assert "Traceback" not in run.stderr


@pytest.mark.parametrize(
    ("generation", "all_cells", "enough"),
    [("1", 189, 40), ("2-five", 168, 40), ("2-one", 84, 25), ("none", 84, 25)],
)
def test_every_cell_is_there_once_and_enough_are_told_in_five_minutes(
    description: Description, generation: str, all_cells: int, enough: int
) -> None:
    cells, processes = list(full(description, generation)), PROCESSES[generation]
    assert (
        len(cells) == len(set(cells)) == len(processes) * len(SIGNALS) * len(states(description)) == all_cells
    )
    chosen = list(telling(description, generation))
    assert len(chosen) >= enough
    assert {cell.process for cell in chosen} == set(processes)
    assert {cell.signal for cell in chosen} == set(SIGNALS)
    assert {cell.state for cell in chosen} >= set(states(description)) - {"GRIPPING cylinder"}
