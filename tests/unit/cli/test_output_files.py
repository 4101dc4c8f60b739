"""`-o x.svg` writes that file, and no folder of this name."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli._main import eehal
from tests.support.refuted import REFUTED

SECOND = "<query><formula>A[] not P.B</formula><comment>[never] Never B.</comment></query></queries>"


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def run(*arguments: str) -> Result:
    return CliRunner().invoke(eehal, arguments)


def is_drawing(name: str) -> bool:
    return ET.parse(name).getroot().tag.endswith("svg")


def test_a_template_is_drawn_into_a_file() -> None:
    drawn = run("model", "show", "--template", "Gripper", "-o", "x.svg")
    assert (drawn.exit_code, drawn.output) == (0, "Gripper: x.svg\n")
    assert is_drawing("x.svg")


def test_several_do_not_fit_into_one_file_and_a_wrong_name_is_guessed() -> None:
    error = str(run("model", "show", "-o", "x.svg").exception)
    assert error.startswith("x.svg: ")
    assert "drawings do not fit into one file. Name a folder, or one of them with --template: " in error
    wrong = run("model", "show", "--template", "Griper", "-o", "x.svg")
    assert str(wrong.exception) == "There is no template 'Griper'. Did you mean 'Gripper'?"
    assert not Path("x.svg").exists()


def test_a_run_of_the_model_is_drawn_into_a_file() -> None:
    assert run("model", "simulate", "--steps", "30", "-o", "x.svg").exit_code == 0
    assert is_drawing("x.svg")
    assert [path.name for path in Path().iterdir()] == ["x.svg"]


def test_a_counterexample_is_drawn_into_a_file_and_several_beside_it() -> None:
    Path("model.xml").write_text(REFUTED)
    result = run("verify", "--model", "model.xml", "-o", "x.svg")
    assert (result.exit_code, is_drawing("x.svg")) == (4, True)
    assert "\nx.svg\n" in result.output
    Path("model.xml").write_text(REFUTED.replace("</queries>", SECOND))
    assert run("verify", "--model", "model.xml", "-o", "y.svg").exit_code == 4
    assert sorted(path.name for path in Path().glob("y*")) == ["y-never.svg", "y-stays.svg"]


def test_a_folder_called_so_stays_one() -> None:
    Path("x.svg").mkdir()
    assert run("model", "show", "--template", "Gripper", "-o", "x.svg").exit_code == 0
    assert {path.suffix for path in Path("x.svg").iterdir()} == {".png", ".svg"}
