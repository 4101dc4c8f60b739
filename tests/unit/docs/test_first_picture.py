"""The moving picture of the README: still where nothing moves, and of the tool that the README shows."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

from end_effector_hal.description import load
from end_effector_lab.figures import timeline
from tests.support.places import DOCS
from tests.support.trace_recordings import INFO, NEVER, PRESSURES
from tests.unit.docs.test_readme import block
from tools.first_picture import SPEED, STILL_S, save_moving

PICTURE = DOCS / "images/failed-grip.svg"
SVG = "{http://www.w3.org/2000/svg}"


def test_a_text_appears_when_its_time_has_come_and_the_verdict_at_the_end(tmp_path: Path) -> None:
    figure = timeline(NEVER, PRESSURES, INFO)
    save_moving(figure, tmp_path / "moving.svg")
    svg = (tmp_path / "moving.svg").read_text(encoding="utf-8")
    start_s, end_s = figure.axes[0].get_xlim()
    whole_s = (end_s - start_s) / SPEED + STILL_S
    appears = {
        name: float(at) / 100 * whole_s for name, at in re.findall(r"@keyframes (\w+)\{0%,([\d.]+)%", svg)
    }
    names = {
        each.get("id"): each[-1].text for each in ElementTree.fromstring(svg).iter(f"{SVG}g") if len(each)
    }
    abort = next(name for name in appears if "abort" in (names[name] or ""))
    assert 18.2 < appears[abort] * SPEED + start_s <= 18.5
    assert max(appears, key=appears.__getitem__) == "verdict"


def test_without_animation_the_whole_figure_is_seen() -> None:
    svg = PICTURE.read_text(encoding="utf-8")
    (style,) = re.findall(r"<style>(.*?)</style>", svg)
    assert style.startswith("@media(prefers-reduced-motion:no-preference){")
    assert [
        each.get("opacity") for each in ElementTree.fromstring(svg).iter(f"{SVG}g") if each.get("class")
    ] == ["0"]
    assert len(svg) < 80_000


def test_it_is_of_the_tool_of_the_readme(tmp_path: Path) -> None:
    (tmp_path / "tool.yaml").write_text(block("yaml"), encoding="utf-8")
    tool, svg = load(tmp_path / "tool.yaml"), PICTURE.read_text(encoding="utf-8")
    assert f"description {tool.name} " in svg
    for name, actuator in tool.actuators.items():
        assert f">{name.capitalize()}</text>" in svg
        assert f"confirmed ≤ −{actuator.confirmed_kpa:g}" in svg
