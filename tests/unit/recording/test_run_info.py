"""run.json: whole or not at all; read whatever it holds."""

import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.recording import RunInfo, Watched, read_run
from tests.support.trace_recordings import INFO


def test_it_comes_back(tmp_path):
    assert INFO.write(tmp_path) == tmp_path / "run.json"
    assert read_run(tmp_path) == read_run(tmp_path / "run.json") == INFO
    assert [file.name for file in tmp_path.iterdir()] == ["run.json"]


def test_the_keys_are_those_of_the_contract(tmp_path):
    content = json.loads(INFO.write(tmp_path).read_text())
    assert content["schema_version"] == 1
    keys = [
        "schema_version", "scenario", "description", "hash", "version", "ros", "started", "actuators",
        "limits", "switches", "simulated", "ros_generation", "start_us", "gaps", "seed",
    ]  # fmt: skip
    assert list(content) == keys


def test_the_channel_of_an_e_stop_is_written_where_there_is_one(tmp_path):
    info = replace(INFO, e_stop="estop_ok")
    assert json.loads(info.write(tmp_path).read_text())["e_stop"] == "estop_ok"
    assert read_run(tmp_path) == info


def test_what_is_violated_comes_back(tmp_path):
    watched = (
        Watched("ee", wrong=True, values=((0.0, "OFF"), (1.5, "GRIPPED"))),
        Watched("x", points=((0.0, 0.0), (2.0, 2.0)), limits=(("<= 1 s", 1.0),), deadline_s=1.0),
    )
    info = replace(INFO, violated="It ends.", violated_s=2.0, because="It does not.", watched=watched)
    info.write(tmp_path)
    assert read_run(tmp_path) == info


@pytest.mark.parametrize(
    "wrong",
    [
        3,
        "x",
        {},
        {"name": "x"},
        {"name": "x", "values": [[1]]},
        {"name": "x", "points": [["a", 0]]},
        {"name": "x", "points": [[0, float("nan")]]},
        {"name": 3, "values": [[0, "OFF"]]},
    ],
)
def test_what_cannot_be_watched_is_left_out_and_said(tmp_path, wrong):
    content = {"violated": "It ends.", "watched": [{"name": "ee", "values": [[0, "OFF"]]}, wrong]}
    (tmp_path / "run.json").write_text(json.dumps(content))
    info = read_run(tmp_path)
    assert info.watched == (Watched("ee", values=((0.0, "OFF"),)),)
    assert info.note.endswith("wrong type of watched.")


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "null", '{"scenario": 3, "ros": "yes", "limits": [1]}', "[" * 100_000]
)
def test_what_is_unusable_is_left_at_its_default(tmp_path, text):
    (tmp_path / "run.json").write_text(text)
    assert read_run(tmp_path) == RunInfo()
    assert read_run(tmp_path).note.startswith(f"{tmp_path}/run.json can only be read in part: ")


def test_what_is_usable_is_taken(tmp_path):
    (tmp_path / "run.json").write_text(
        '{"scenario": "nominal", "limits": {"a": {"attempts": 3}, "b": 1}, "later": {}}'
    )
    info = read_run(tmp_path)
    assert info == RunInfo(scenario="nominal", limits={"a": {"attempts": 3}})
    assert (info.attempts("a"), info.attempts("b")) == (3, None)
    assert info.note.endswith("wrong type of limits.")


def test_a_missing_file_is_no_error(tmp_path):
    assert read_run(tmp_path) == read_run(tmp_path / "none" / "run.json") == RunInfo()
    assert read_run(tmp_path).note == ""


@pytest.mark.parametrize("number", [0, -1, True, 2.5, "3", None])
def test_attempts_that_make_no_sense_are_unknown(number):
    assert RunInfo(limits={"a": {"attempts": number}}).attempts("a") is None


@given(st.binary(max_size=300))
def test_arbitrary_bytes_never_raise(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("run") / "run.json"
    path.write_bytes(data)
    read_run(path)
