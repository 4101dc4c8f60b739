"""`eehal plugin` in a fresh environment: a kind of one's own is added, used, kept over a new product, and removed."""

from __future__ import annotations

import json

import pytest

from .conftest import Environment

pytestmark = [pytest.mark.wall, pytest.mark.thinned, pytest.mark.timeout(300)]
TOOL = "examples/kinds/jaw/end_effector.yaml"


def test_a_kind_is_added_used_and_removed(fresh: Environment) -> None:
    assert "unknown kind of actuator (jaw)" in fresh.run("eehal", "check", TOOL, expected=2).stderr
    done = fresh.run("eehal", "plugin", "add", "./examples/kinds/jaw")
    assert "kind jaw, physics jaw, codec jaw-line" in done.stdout
    assert "with all rights of that program" in done.stderr
    fresh.run("eehal", "check", TOOL)
    fresh.run("eehal", "demo", TOOL, "--no-ros", "--only", "nominal", "-o", "runs/plugin")
    (listed,) = json.loads(fresh.run("eehal", "plugin", "list", "--json").stdout)["plugins"]
    assert (listed["name"], listed["fault"]) == ("eehal-jaw", "")
    fresh.run("eehal", "plugin", "remove", "eehal-jaw")
    fresh.run("eehal", "check", TOOL, expected=2)
    assert "There is no plug-in" in fresh.run("eehal", "plugin", "remove", "eehal-jaw", expected=2).stderr


def test_one_of_another_user_is_refused_in_a_sentence(fresh: Environment) -> None:
    (folder := fresh.folder / "env/plugins").mkdir(exist_ok=True)
    folder.chmod(0o777)
    said = fresh.run("eehal", "plugin", "add", "./examples/codecs/gauge", expected=2).stderr
    folder.chmod(0o755)
    assert "Plug-ins cannot be written: others may write" in said
