"""A plug-in whose import does not end disturbs nobody who does not use it, and is named to who does."""

from __future__ import annotations

import os
import subprocess
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path

import pytest

from end_effector_hal import plugins
from end_effector_hal.codecs import _registry as codecs
from end_effector_hal.codecs import load_tool
from end_effector_hal.description import profile_path
from end_effector_hal.errors import DescriptionError, UsageError
from end_effector_hal.kinds import _registry as kinds
from end_effector_lab.processes import EEHAL
from tests.support.places import ROOT

GROUPS = ("codecs", "kinds", "physics", "commands", "figures", "simulation", "bags", "sweep")


@pytest.fixture
def hanging(tmp_path: Path) -> Path:
    """A distribution that adds a plug-in `evil` of every sort."""
    (tmp_path / "evil.py").write_text("import time\nprint('imported', flush=True)\ntime.sleep(600)\n")
    info = tmp_path / "evil-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: evil\nVersion: 1\n")
    points = (f"[end_effector_hal.{group}]\nevil = evil:Evil\n" for group in GROUPS)
    (info / "entry_points.txt").write_text("\n".join(points))
    return tmp_path


@pytest.mark.parametrize("words", [("check",), ("doctor", "--only", "description,python", "--json")])
def test_who_does_not_use_it_does_not_import_it(hanging: Path, words: tuple[str, ...]) -> None:
    tools = (profile_path(), ROOT / "examples/tools/double_acting_jaw/end_effector.yaml")
    bad = hanging / "bad.yaml"  # hints are looked for in all kinds
    bad.write_text(tools[1].read_text().replace("kind: gripper", "kind: gripper\n    colour: red"))
    path = os.pathsep.join((str(hanging), os.environ.get("PYTHONPATH", "")))
    for tool, code in ((tools[0], 0), (tools[1], 0), (bad, 2)):
        done = subprocess.run(
            [*EEHAL, *words, str(tool)],
            env=os.environ | {"PYTHONPATH": path},
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        assert (done.returncode, "imported" in done.stdout) == (code, False), done.stdout + done.stderr


@pytest.fixture
def evil(hanging: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(hanging))
    points = EntryPoints(EntryPoint("evil", "evil:Evil", f"end_effector_hal.{group}") for group in GROUPS)
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **kw: points.select(**kw))
    monkeypatch.setattr(plugins, "LOAD_S", 0.2)
    for plugged in (codecs._CODECS, kinds._KINDS):
        monkeypatch.setattr(plugged, "_begun", {})


TOOL = """\
name: cup
link: {{port: /dev/ttyUSB0, codec: {codec}}}
sequence: [cup]
actuators: {{cup: {{kind: {kind}, line: GPIO1, channel: bottom}}}}
supply: {{channel: none}}
"""


@pytest.mark.usefixtures("evil")
def test_who_uses_it_reads_that_its_import_does_not_end() -> None:
    for get in (codecs.get_codec, kinds.get_kind):
        for _ in range(2):
            with pytest.raises(UsageError, match=r"evil: its import did not end within 0\.2 s\."):
                get("evil")


@pytest.mark.usefixtures("evil")
@pytest.mark.parametrize(("codec", "kind"), [("ees1-ascii", "evil"), ("evil", "vacuum")])
def test_check_names_it_and_means_nothing_else(codec: str, kind: str, tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(TOOL.format(codec=codec, kind=kind))
    with pytest.raises(DescriptionError) as refused:
        load_tool(path)
    said = str(refused.value)
    assert "evil: its import did not end within 0.2 s" in said
    assert "did you mean 'evil'" not in said
    assert "that can be loaded" in said
