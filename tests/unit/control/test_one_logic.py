"""There is one logic: a change of the description or of the XML changes the run, with no change of code."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from end_effector_hal.description import SHIPPED_AUTOMATA, Description, load, profile_path
from tests.support.virtual_tool import VirtualTool

Edit = Callable[[str], str]


@pytest.fixture
def edited(tmp_path: Path) -> Callable[..., Description]:
    def make(yaml: Edit = str, xml: Edit = str) -> Description:
        for path, edit in ((profile_path(), yaml), (SHIPPED_AUTOMATA, xml)):
            text = path.read_text()
            changed = edit(text)
            assert edit is str or changed != text
            (tmp_path / path.name).write_text(changed)
        return load(tmp_path / "end_effector.yaml")

    return make


def run(description: Description, scenario: str = "nominal") -> VirtualTool:
    tool = VirtualTool(description, scenario)
    tool.play(1.0, "grip", 25.0)
    return tool


def test_a_time_out_of_the_description_is_that_of_the_run(edited: Callable[..., Description]) -> None:
    description = edited(
        lambda text: text.replace("    kind: cylinder\n", "    kind: cylinder\n    timeout_s: 2.0\n")
    )
    tool = run(description, "never-confirms:cylinder")
    edges = [at for at, line, _ in tool.edges if line == "SODIMM_210"]
    assert [round((b - a) / 1e6, 6) for a, b in pairwise(edges)] == [2.0, 1.0, 2.0, 1.0, 2.0]


def test_the_order_of_the_description_is_that_of_the_run(edited: Callable[..., Description]) -> None:
    description = edited(
        lambda text: text.replace(
            "[bottom_vacuum, cylinder, top_vacuum]", "[top_vacuum, bottom_vacuum, cylinder]"
        )
    )
    tool = run(description)
    assert [line for _, line, _ in tool.edges] == ["SODIMM_212", "SODIMM_208", "SODIMM_210"]


def test_the_number_of_steps_is_that_of_the_description(edited: Callable[..., Description]) -> None:
    def without_top(text: str) -> str:
        head, rest = text.split("  top_vacuum:\n")
        return head.replace(", top_vacuum]", "]") + rest[rest.index("tool_changer:") :]

    tool = run(edited(without_top))
    assert tool.status.ee == 3
    assert tool.status.actuators == (2, 2)


def test_an_edge_of_the_xml_is_the_behaviour(edited: Callable[..., Description]) -> None:
    def one_attempt_less(text: str) -> str:
        for guard in ("attempt &lt; ATTEMPTS[part][i]", "attempt == ATTEMPTS[part][i]"):
            assert guard in text
            text = text.replace(guard, guard + " - 1")
        return text

    tool = run(edited(xml=one_attempt_less), "never-confirms:cylinder")
    assert [step.attempts for step in tool.status.steps] == [1, 2, 0]
