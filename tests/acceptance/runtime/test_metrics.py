"""The metrics of a tool as Prometheus reads them: `eehal serve` and `eehal page` as processes, over HTTP."""

from __future__ import annotations

import re
import urllib.error
import urllib.request
from pathlib import Path

import pytest
from prometheus_client.parser import text_string_to_metric_families

from end_effector_hal.runtime import EndEffector
from end_effector_lab.demo import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(180)]
SECRET = "0123456789abcdef"


def read(url: str, secret: str = SECRET) -> tuple[str, str]:
    """The answer to a scraper, and its type."""
    asked = urllib.request.Request(url, headers={"Authorization": f"Bearer {secret}"})
    with urllib.request.urlopen(asked, timeout=20) as answer:
        return answer.read().decode(), answer.headers["content-type"]


def values(url: str) -> dict[str, dict[tuple[str, ...], float]]:
    """All samples by name, and by the values of their labels but the tool's in alphabetical order."""
    found: dict[str, dict[tuple[str, ...], float]] = {}
    for family in text_string_to_metric_families(read(url)[0]):
        for sample in family.samples:
            assert sample.labels["tool"] == "verdin_gripper"
            labels = tuple(value for name, value in sorted(sample.labels.items()) if name != "tool")
            found.setdefault(sample.name, {})[labels] = sample.value
    return found


def test_a_scraper_reads_a_grip_over_http(world: World, tmp_path: Path) -> None:
    (tmp_path / "secret").write_text(f"{SECRET}\n")
    path = str(world.description_path)
    options = ("--port", "0", "--metrics-token", str(tmp_path / "secret"))
    log = tmp_path / "page.log"
    world.children.start("page", [*EEHAL, "page", path, *options], log=log)
    printed = wait_until(
        "the address", lambda: re.search(r"http://[^/]+/", log.read_text()) if log.exists() else None
    )
    url = f"{printed[0]}metrics"
    assert values(url)["eehal_up"] == {(): 0}
    world.children.start("hal", [*EEHAL, "serve", path], log=tmp_path / "hal.log")
    wait_until("the HAL", lambda: values(url)["eehal_up"] == {(): 1})
    with EndEffector.connect(world.description_path, timeout_s=PATIENCE_S) as tool:
        tool.wait_ready(PATIENCE_S)
        assert tool.grip().succeeded
        held = wait_until("the grip", lambda: (now := values(url))["eehal_held"][()] and now)
        assert held["eehal_grips_total"]["GRIPPED", ""] == 1
        assert held["eehal_attempts_total"]["cylinder", "confirmed"] == 1
        assert held["eehal_margin_pascals"]["bottom_vacuum",] > 1000
        assert set(held["eehal_link_up"].values()) == {1}
        assert min(held["eehal_link_frames_total"].values()) > 10
        assert tool.drop().succeeded
    text, kind = read(url)
    assert kind.startswith("text/plain; version=")
    assert "# TYPE eehal_grips_total counter" in text
    for secret in ("", SECRET[:-1]):
        with pytest.raises(urllib.error.HTTPError, match="401"):
            read(url, secret)
