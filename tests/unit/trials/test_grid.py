"""Every fault at every moment: the cells, what a fault must cause, and that a wrong tool is found."""

from __future__ import annotations

import csv
import json
from collections import Counter
from functools import cache
from io import StringIO
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.kinds import ChannelReadings
from end_effector_hal.kinds.cylinder import CylinderDetector
from end_effector_hal.runtime.outputs import OutputMapping
from end_effector_lab.commands._matrix import command
from end_effector_lab.trials import (
    COMMANDS,
    HELD,
    REST,
    Cell,
    Effects,
    Outcome,
    cells_of,
    fmea,
    moments,
    play,
    thinned,
)
from tests.support.nightly import NIGHTLY
from tests.support.places import ROOT, WRITTEN_OUT

SHIPPED = load(profile_path())


@cache
def all_cells() -> dict[str, Cell]:
    return {cell.id: cell for cell in cells_of(SHIPPED, moments(SHIPPED))}


def test_every_combination_is_a_cell_once() -> None:
    cells = list(all_cells().values())
    faults, when = {cell.fault for cell in cells}, {cell.moment.name for cell in cells}
    at_once = [cell for cell in cells if cell.at_once]
    assert len(cells) - len(at_once) == len(faults) * len(when) * len(COMMANDS) >= 18_000
    assert len(at_once) == len(when) * 3
    assert {cell.fault for cell in at_once} == {"nominal"}
    assert {"nominal", "leak:top_vacuum:4", "silent-after:0", "fails:cylinder:3"} <= faults
    assert {
        "grip cylinder on -1ms",
        "grip cylinder on",
        "grip cylinder on +1ms",
        "grip cylinder on, between",
    } <= when


@pytest.mark.parametrize(
    ("cell", "outcome"),
    [
        ("nominal @ grip GRIPPED, between + kill hal, at once", Outcome.SUCCESS),
        ("nominal @ grip GRIPPED, between + kill both, at once", Outcome.SUCCESS),
        ("nominal @ grip top_vacuum on, between + kill hal, at once", Outcome.UNWOUND),
        ("nominal @ release top_vacuum off, between + kill arbiter, at once", Outcome.RELEASED),
    ],
)
def test_who_is_restarted_at_once_finds_what_was_left(cell: str, outcome: Outcome) -> None:
    found = play(SHIPPED, all_cells()[cell])
    assert (found.outcome, found.objections, found.dropped) == (outcome, (), False)
    assert found.id == cell


@pytest.mark.parametrize("every", [2, 7, 50, 400])
def test_a_thinned_matrix_has_each_command_and_all_kinds_of_the_rest(every: int) -> None:
    cells = thinned(list(all_cells().values()), every)
    assert len(set(cells)) == len(cells) == -(-len(all_cells()) // every)
    of_each = Counter(cell.command for cell in cells if not cell.at_once)
    assert of_each.keys() == set(COMMANDS)
    assert max(of_each.values()) - min(of_each.values()) <= 2 + len(cells) // 500
    enough = len(cells) >= 100
    assert not enough or {cell.moment.name for cell in cells} == {c.moment.name for c in all_cells().values()}
    assert not enough or {cell.name for cell in cells} == {cell.name for cell in all_cells().values()}


def test_moments_say_what_the_tool_is_doing() -> None:
    when = {cell.moment.name: cell.moment for cell in all_cells().values()}
    bottom, cylinder, top = SHIPPED.sequence
    assert when["rest"].engaged == ()
    assert (when["grip cylinder on -1ms"].phase, when["grip cylinder on -1ms"].engaged) == ("grip", (bottom,))
    assert when["grip cylinder on"].engaged == (bottom, cylinder)
    assert (when["grip GRIPPED"].phase, when["grip GRIPPED"].engaged) == ("held", (bottom, cylinder, top))
    assert (when["release top_vacuum off"].phase, when["release top_vacuum off"].engaged) == (
        "release",
        (bottom, cylinder),
    )


def effects(fault: str, phase: str = REST, *engaged: str, tool: Description = SHIPPED) -> Effects:
    return Effects(tool, fault, phase, engaged)


@pytest.mark.parametrize(
    ("fault", "refused"),
    [
        ("silent-after:0", True),
        ("supply:350", True),
        ("supply:480", False),
        ("invalid:cylinder", True),
        ("locked-shows:tool_changer:0", True),
        ("locked-shows:tool_changer:1", False),
        ("never-confirms:cylinder", False),
    ],
)
def test_a_fault_that_is_seen_refuses_a_grip(fault: str, refused: bool) -> None:
    assert effects(fault).refuses_grip is refused


def test_low_air_refuses_a_grip_only_where_it_is_read() -> None:
    jaw = load(ROOT / "examples" / "tools" / "double_acting_jaw" / "end_effector.yaml")
    assert not effects("supply:350", tool=jaw).refuses_grip


@pytest.mark.parametrize(
    ("fault", "alarm"),
    [
        ("nominal", False),
        ("invalid:top_vacuum", True),
        ("frozen-after:cylinder:0", True),
        ("silent-after:0", True),
        ("unlocked-shows:tool_changer:1", True),
    ],
)
def test_missing_evidence_of_a_held_part_needs_an_alarm(fault: str, alarm: bool) -> None:
    assert effects(fault, HELD, *SHIPPED.sequence).needs_alarm is alarm


@pytest.mark.parametrize(
    ("fault", "harmless"),
    [
        ("nominal", True),
        ("fails:cylinder:2", True),
        ("fails:cylinder:3", False),
        ("leak:top_vacuum:4", True),
        ("leak:top_vacuum:40", False),
        ("stuck-release:cylinder", False),
        ("shows:cylinder:0", False),
    ],
)
def test_a_grip_must_succeed_with_a_harmless_fault(fault: str, harmless: bool) -> None:
    assert effects(fault).is_harmless is harmless


EACH = 101 if NIGHTLY else 2_999


def test_a_spread_of_cells_is_explained() -> None:
    found = [play(SHIPPED, cell) for cell in list(all_cells().values())[7::EACH]]
    assert {each.id: each.objections for each in found if each.objections} == {}
    assert not any(each.dropped for each in found)
    assert len({each.outcome for each in found}) >= 3


def test_a_cell_is_the_same_each_time() -> None:
    cell = all_cells()["fails-once:cylinder @ grip cylinder on + kill arbiter"]
    assert play(SHIPPED, cell) == play(SHIPPED, cell)


def test_no_air_is_no_proof_of_a_cylinder(monkeypatch: pytest.MonkeyPatch) -> None:
    """Found by the matrix: 85 % of no supply pressure was reached by a rod at rest."""
    cell = all_cells()["supply:0 @ grip cylinder on + none"]
    assert play(SHIPPED, cell).outcome == Outcome.FAILED

    def as_it_was(detector: CylinderDetector, readings: ChannelReadings) -> float:
        supply = readings.fresh[detector._supply.channel]
        return detector._actuator.extended_fraction * supply - 20_000

    monkeypatch.setattr(CylinderDetector, "_threshold_pa", as_it_was)
    assert any("GRIPPED, and cylinder does not grip" in each for each in play(SHIPPED, cell).objections)


def test_a_wrong_last_will_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(OutputMapping, "last_will", lambda *_: ())
    played = play(SHIPPED, all_cells()["nominal @ grip cylinder on + kill hal"])
    assert played.objections
    assert played.outcome == Outcome.HELD


def test_a_last_will_that_drops_a_held_part_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    real = OutputMapping.last_will

    def drops(outputs: OutputMapping, status, ending="process_death"):  # type: ignore[no-untyped-def]
        return real(outputs, status.__class__(**{**_fields(status), "held": False, "ee": 1}), ending)

    monkeypatch.setattr(OutputMapping, "last_will", drops)
    played = play(SHIPPED, all_cells()["nominal @ grip GRIPPED, between + kill hal"])
    assert played.dropped
    assert played.objections


def _fields(status: object) -> dict[str, object]:
    return {name: getattr(status, name) for name in status.__dataclass_fields__}  # type: ignore[attr-defined]


def run(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(command, arguments)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.output


def test_the_command_writes_its_report_into_a_new_folder(tmp_path: Path) -> None:
    arguments = ["--only", "fails:cylinder:2 @ release STAND_BY -1ms", "--jobs", "1", "-o", str(tmp_path)]
    code, printed = run(*arguments, "--json")
    found = json.loads(printed.splitlines()[-1])
    assert code == 0
    assert (found["dropped"], found["unexplained"], found["not_played"]) == (0, 0, 0)
    assert found["cells"] == len(COMMANDS)
    assert found["cells"] + found["left_out"] == len(all_cells())
    again = CliRunner().invoke(command, arguments)
    assert "This folder is not empty" in str(again.exception)
    assert "fails:cylinder:2" in (tmp_path / "report.html").read_text()
    rows = list(csv.DictReader(StringIO((tmp_path / "fmea.csv").read_text())))
    assert [row["item"] for row in rows] == ["Cylinder"]
    assert rows[0]["severity"] == rows[0]["occurrence"] == ""


def test_an_unknown_cell_is_refused_with_the_nearest() -> None:
    result = CliRunner().invoke(command, ["--cell", "nominal @ resting + none"])
    assert "Did you mean 'nominal @ rest + none'?" in str(result.exception)


@pytest.mark.parametrize("more", [["--only", "supply"], ["--every", "2"], ["--list"], ["--jobs", "2"]])
def test_one_cell_is_not_chosen_twice(more: list[str]) -> None:
    result = CliRunner().invoke(command, ["--cell", "nominal @ rest + none", *more])
    assert "--cell plays one cell" in str(result.exception)


def test_an_fmea_has_a_row_for_each_fault_and_function() -> None:
    cells = [
        cell for cell in all_cells().values() if cell.fault == "leak:top_vacuum:40" and cell.command == "none"
    ]
    chosen = [cell for cell in cells if cell.moment.name in ("rest", "grip GRIPPED, between")]
    text = fmea(SHIPPED, chosen, {cell.id: play(SHIPPED, cell) for cell in chosen})
    rest, held = csv.DictReader(StringIO(text))
    assert (rest["function"], held["function"]) == ("begin a grip", "hold")
    assert rest["reaction"] == "declared failure (1)"
    assert held["reaction"] == "held with alarm (1)"
    assert "lost" in held["detection"]


def test_a_part_that_its_device_lets_go_is_told_apart() -> None:
    """Nobody speaks to an EPick for a second: it releases, as its description says."""
    tool = load_tool(WRITTEN_OUT / "epick_commanded.yaml")
    cells = {cell.id: cell for cell in cells_of(tool, moments(tool))}
    fallen = play(tool, cells["nominal @ grip GRIPPED, between + kill arbiter"])
    assert (fallen.let_go, fallen.dropped, fallen.objections) == (True, False, ())
    assert fallen.told.startswith("No valid reading of Cup while it holds a part")
    silent = [cell for cell in cells.values() if cell.name == "silent-after" and cell.moment.phase == "held"]
    unheard = [cell for cell in silent if cell.command == "none"]
    rows = {cell.id: play(tool, cell) for cell in unheard[-1:]}
    (row,) = csv.DictReader(StringIO(fmea(tool, unheard[-1:], rows)))
    assert row["effect on the part"] == "falls: its device lets go when it hears nothing"
    assert row["unexplained"] == "0"


def test_what_cannot_be_read_after_a_restart_may_hold_something() -> None:
    tool = load_tool(WRITTEN_OUT / "gripper_2f85.yaml")
    cells = {cell.id: cell for cell in cells_of(tool, moments(tool))}
    played = play(tool, cells["no-answers:1 @ rest + kill both"])
    assert (played.outcome, played.objections) == (Outcome.HELD, ())
    assert play(tool, cells["nominal @ rest + kill both"]).outcome == Outcome.AT_REST
