"""CONTRIBUTING is followed to the letter, in a fresh environment."""

from __future__ import annotations

import re

import pytest

from .conftest import ROOT, Environment

pytestmark = [pytest.mark.wall, pytest.mark.thinned, pytest.mark.timeout(300)]


def section(title: str) -> str:
    """What stands under a heading of CONTRIBUTING.md."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    found = re.search(rf"^## {re.escape(title)}\n(.*?)(?=^## |\Z)", text, flags=re.DOTALL | re.MULTILINE)
    assert found, title
    return found[1]


def commands(title: str) -> str:
    """The commands that stand there."""
    (block,) = re.findall(r"^```sh\n(.*?)^```", section(title), flags=re.DOTALL | re.MULTILINE)
    return str(block)


@pytest.mark.parametrize(
    ("title", "result"),
    [
        ("A new kind of device", "Nominal: GRIPPED, then dropped"),
        ("A new codec", "link      /dev/ttyUSB0, scale, 19200 baud"),
    ],
)
def test_the_way_leads_there(fresh: Environment, title: str, result: str) -> None:
    assert len(commands(title).splitlines()) <= 10
    done = fresh.run("bash", "-e", "-c", commands(title))
    assert result in done.stdout


def test_a_new_command_is_found(fresh: Environment) -> None:
    point, code = re.findall(
        r"^```(?:toml|python)\n(.*?)^```", section("A new command of `eehal`"), flags=re.DOTALL | re.MULTILINE
    )
    package = fresh.folder / "hello"
    (package / "src" / "my_package").mkdir(parents=True)
    backend = '[build-system]\nrequires = ["uv_build>=0.7"]\nbuild-backend = "uv_build"\n'
    project = '[project]\nname = "my-package"\nversion = "1"\n'
    (package / "pyproject.toml").write_text(backend + project + point, encoding="utf-8")
    (package / "src" / "my_package" / "__init__.py").write_text(code, encoding="utf-8")
    fresh.run("uv", "pip", "install", "--no-deps", "./hello")
    assert "greet a tool" in fresh.run("eehal", "--help").stdout
    tool = ROOT / "src/end_effector_hal/profiles/verdin_gripper/end_effector.yaml"
    assert fresh.run("eehal", "hello", tool).stdout == "Hello, verdin_gripper.\n"
