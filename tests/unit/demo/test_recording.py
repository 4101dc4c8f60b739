"""The three files of a recording, whoever writes them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from end_effector_hal.description import SHIPPED_AUTOMATA, Description, content_hash, profile_path
from end_effector_hal.description import load as load_description
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import Recording, read_pressures, read_run, read_states, run_info
from end_effector_hal.wires import now_us

S = 1_000_000


def test_the_first_state_is_the_start(verdin: Description, tmp_path: Path) -> None:
    begun = now_us() + 10 * S
    with Recording(tmp_path, verdin) as recording:
        recording.values(begun - S, {"bottom": -1000})
        assert recording.state(begun, 0, -1, [0, 0, 0])
        recording.values(
            begun + S // 2, {"bottom": -78_250, "cylinder": None, "supply": 600_000, "locked": True}
        )
        assert not recording.state(begun + S, 0, -1, [0, 0, 0])
        assert recording.state(begun + 2 * S + 1, 6, -1, [0, 0, 0])
    assert [row.time_s for row in read_states(tmp_path / "states.csv").rows] == [0.0, 2.000001]
    pressures = read_pressures(tmp_path / "pressures.csv")
    assert pressures.channels == ("bottom", "cylinder", "top", "supply")
    assert pressures.samples == ((0.5, (-78.25, None, None, 600.0)),)


def test_a_state_that_is_old_when_it_begins_is_of_the_start(verdin: Description, tmp_path: Path) -> None:
    with Recording(tmp_path, verdin) as recording:
        begun = now_us()
        recording.state(begun - 600 * S, 6, -1, [0, 0, 0])
        recording.state(begun + 5 * S, 1, 2, [0, 0, 0])
    rows = read_states(tmp_path / "states.csv").rows
    assert rows[0].time_s == 0.0
    assert rows[1].time_s == pytest.approx(5.0, abs=0.2)


def test_what_is_there_is_continued_on_its_own_time(verdin: Description, tmp_path: Path) -> None:
    with Recording(tmp_path, verdin, scenario="nominal") as recording:
        recording.state(now_us(), 6, -1, [0, 0, 0])
    content = json.loads((tmp_path / "run.json").read_text())
    begun = content["started"]
    with Recording(tmp_path, verdin, ros=True) as recording:
        recording.state(now_us() + 30 * S, 1, 2, [0, 0, 0])
    rows = read_states(tmp_path / "states.csv").rows
    assert [row.end_effector for row in rows] == [6, 1]
    assert 30.0 <= rows[1].time_s < 32.0
    info = read_run(tmp_path)
    assert (info.started, info.scenario, info.ros) == (begun, "nominal", True)


def test_a_folder_that_cannot_be_made(verdin: Description, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="cannot be made"):
        Recording(tmp_path / "file" / "run", verdin)


def test_the_recording_of_another_tool_is_not_continued(verdin: Description, tmp_path: Path) -> None:
    (tmp_path / "states.csv").write_text("time_s,end_effector,command,claw\n")
    with pytest.raises(UsageError, match="another header"):
        Recording(tmp_path, verdin)
    assert not (tmp_path / "run.json").exists()


def test_a_link_that_carries_no_pressures(verdin: Description, tmp_path: Path) -> None:
    link = verdin.link.model_copy(update={"codec": "legacy-nibble"})
    with Recording(tmp_path, verdin.model_copy(update={"link": link})) as recording:
        recording.state(now_us(), 6, -1, [0, 0, 0])
        recording.values(now_us(), {"bottom": True})
    assert not (tmp_path / "pressures.csv").exists()


def test_the_hash_is_of_the_tool_and_not_of_its_place(verdin: Description, tmp_path: Path) -> None:
    assert content_hash(verdin) == content_hash(verdin.with_virtual("/tmp/a", "/tmp/b"))
    for name, old, new in (
        ("end_effector.xml", "2000, 2000", "2000, 2001"),
        ("end_effector.yaml", "timeout_s: 5.0", "timeout_s: 5.1"),
    ):
        folder = tmp_path / name
        folder.mkdir()
        for path in (SHIPPED_AUTOMATA, profile_path()):
            text = path.read_text()
            assert path.name != name or old in text
            (folder / path.name).write_text(text.replace(old, new) if path.name == name else text)
        assert content_hash(load_description(folder / "end_effector.yaml")) != content_hash(verdin)


def test_run_json_says_what_a_figure_needs(verdin: Description) -> None:
    info = run_info(verdin, scenario="nominal", ros=True)
    assert info.actuators == {"bottom_vacuum": "vacuum", "cylinder": "cylinder", "top_vacuum": "vacuum"}
    assert info.limits["bottom_vacuum"] == {
        "channel": "bottom", "kind": "vacuum", "attempts": 3,
        "confirmed_kpa": 55.0, "gone_kpa": 10.0, "lost_kpa": 50.0, "secure_kpa": 75.0,
    }  # fmt: skip
    assert info.limits["cylinder"]["confirmed_kpa"] == pytest.approx(510.0)
    assert info.simulated is False
    assert run_info(verdin.with_virtual("a", "b")).simulated is True
