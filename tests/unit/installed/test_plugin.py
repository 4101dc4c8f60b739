"""`eehal plugin`: what it refuses without changing anything, and that a broken plug-in stops nobody else."""

from __future__ import annotations

import json
import os
import re
import shutil
import stat
import sys
import zipfile
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import pytest

from end_effector_hal import plugins
from end_effector_hal.cli.plugin import _check, _package, _requirement
from end_effector_hal.cli.plugin._requirement import unmet
from end_effector_hal.cli.plugin._store import add, added, remove
from end_effector_hal.codecs import codec_names, get_codec
from end_effector_hal.errors import UsageError
from tests.support.places import ROOT

GAUGE = ROOT / "examples/codecs/gauge"
PROJECT = '[project]\nname = "Eehal_Scale"\nversion = "1"\ndependencies = [{needs}]\n'
CODEC = '[project.entry-points."end_effector_hal.codecs"]\n'


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty folder of plug-ins, for this process and for those that it starts."""
    monkeypatch.setattr(plugins, "FOLDER", tmp_path / "plugins")
    monkeypatch.setattr(sys, "path", [*sys.path])
    yield tmp_path / "plugins"
    for name in [each for each in sys.modules if each.startswith(("eehal_gauge", "scale"))]:
        del sys.modules[name]


def package(
    folder: Path, code: str, *, points: str = CODEC + 'scale = "scale:codec"\n', needs: str = ""
) -> Path:
    """A plug-in with one module."""
    (made := folder / "scale").mkdir()
    (made / "pyproject.toml").write_text(PROJECT.format(needs=needs) + points)
    (made / "scale.py").write_text(code)
    return made


def wheel(folder: Path, files: dict[str, str]) -> Path:
    with zipfile.ZipFile(made := folder / "eehal_scale-1-py3-none-any.whl", "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return made


METADATA = "Metadata-Version: 2.1\nName: eehal-scale\nVersion: 1\n"
POINTS = "[end_effector_hal.codecs]\nscale = scale:codec\n[console_scripts]\nls = scale:main\n"
WHEEL = {
    "scale.py": (GAUGE / "src/eehal_gauge/__init__.py").read_text().replace("gauge", "codec"),
    "eehal_scale-1.dist-info/METADATA": METADATA,
    "eehal_scale-1.dist-info/entry_points.txt": POINTS,
}


def test_a_folder_is_copied_compiled_and_found_by_every_user(folder: Path) -> None:
    before = os.umask(0o077)
    try:
        found = add(GAUGE)
    finally:
        os.umask(before)
    assert (found.name, found.version, found.brings) == ("eehal-gauge", "0.1.0", ("codec gauge",))
    assert "gauge" in codec_names()
    assert get_codec("gauge").name == "gauge"
    files = [each for each in folder.rglob("*") if each.is_file()]
    assert any(each.suffix == ".pyc" for each in files)
    assert {stat.S_IMODE(each.stat().st_mode) for each in files} == {0o644}
    (listed,) = added()
    assert (listed.name, listed.version, listed.brings, listed.fault) == (
        *(found.name, found.version),
        found.brings,
        "",
    )


def test_a_wheel_brings_its_entry_points_for_this_product_only(tmp_path: Path, folder: Path) -> None:
    assert add(wheel(tmp_path, WHEEL)).brings == ("codec scale",)
    (points,) = folder.rglob("entry_points.txt")
    assert points.read_text() == "[end_effector_hal.codecs]\nscale = scale:codec\n"


def test_it_is_replaced_and_removed(tmp_path: Path, folder: Path) -> None:
    add(wheel(tmp_path, WHEEL))
    later = {
        name.replace("-1.", "-2."): text.replace("Version: 1", "Version: 2") for name, text in WHEEL.items()
    }
    add(wheel(tmp_path, later))
    assert [each.version for each in added()] == ["2"]
    with pytest.raises(UsageError, match=r"There is no plug-in 'scale'. There are: eehal-scale."):
        remove("scale")
    assert remove("Eehal_Scale") == "eehal-scale"
    assert (list(added()), list(folder.iterdir())) == ([], [])


CLICK = version("click")
BAD = {
    "own name": ({"points": CODEC + 'ees1-ascii = "scale:codec"\n'}, "end-effector-hal has a codec ees1-ascii already"),
    "own kind": (
        {"points": '[project.entry-points."end_effector_hal.kinds"]\nvacuum = "scale:codec"\n'},
        "end-effector-hal has a kind vacuum already",
    ),
    "none of ours": ({"points": '[project.entry-points.pytest11]\nscale = "scale"\n'}, "declares no entry point"),
    "no such group": (
        {"points": '[project.entry-points."end_effector_hal.robots"]\nscale = "scale:codec"\n'},
        "There is no group of entry points end_effector_hal.robots",
    ),
    "no module": ({"points": CODEC + 'scale = "balance:codec"\n'}, "names the module balance, which is not in it"),
    "no object": ({"points": CODEC + 'scale = "scale; import os"\n'}, "is no NAME"),
    "a need": ({"needs": '"click", "no-such-package>=2"'}, "needs no-such-package, which is not installed"),
    "another version": ({"needs": '"click>=8.1,<8.1.1"'}, f"needs click>=8.1,<8.1.1, and {CLICK} is installed"),
    "no requirement": ({"needs": '"&click"'}, "needs '&click', which is no requirement"),
    "no project": ({"points": "[project"}, "with name and version (TOMLDecodeError"),
    "it raises": ({"code": "import nowhere"}, "No module named 'nowhere'"),
    "no codec": ({"code": "codec = 1"}, "this is not a codec"),
    "it exits": ({"code": "import os; os._exit(0)"}, "Its import ended the program"),
    "it hangs": ({"code": "import time; time.sleep(600)"}, "Its import did not end"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_what_is_refused_changes_nothing(
    case: str, tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given, sentence = BAD[case]
    if case == "it hangs":
        monkeypatch.setattr(_check, "LONGEST_S", 1.0)
    made = package(tmp_path, **{"code": WHEEL["scale.py"], **given})
    with pytest.raises(UsageError, match=re.escape(sentence)):
        add(made)
    assert not folder.exists() or list(folder.iterdir()) == []


def test_a_module_that_is_there_is_not_hidden(tmp_path: Path) -> None:
    made = package(tmp_path, "", points=CODEC + 'scale = "json:codec"\n')
    (made / "scale.py").rename(made / "json.py")
    with pytest.raises(UsageError, match="There is a module json already"):
        add(made)


BAD_WHEELS = {
    "../scale.py": "has a file that belongs to no module",
    "/scale.py": "has a file that belongs to no module",
    "eehal_scale-1.data/scripts/ls": "has a file that belongs to no module",
    "other-1.dist-info/METADATA": "has no valid METADATA",
}


@pytest.mark.parametrize("name", BAD_WHEELS)
def test_a_bad_wheel_is_refused(name: str, tmp_path: Path, folder: Path) -> None:
    with pytest.raises(UsageError, match=BAD_WHEELS[name]):
        add(wheel(tmp_path, {**WHEEL, name: METADATA}))
    assert not folder.exists()


def test_a_damaged_wheel_and_one_without_metadata_are_refused(tmp_path: Path) -> None:
    made = wheel(tmp_path, {"scale.py": ""})
    with pytest.raises(UsageError, match="has no valid METADATA"):
        add(made)
    made.write_bytes(b"PK" * 100)
    with pytest.raises(UsageError, match="The wheel is damaged"):
        add(made)


def test_its_size_is_bounded_and_a_link_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = shutil.copytree(GAUGE, tmp_path / "gauge")
    (made / "src/eehal_gauge/link.py").symlink_to("/etc/passwd")
    with pytest.raises(UsageError, match="only regular files"):
        add(made)
    (made / "src/eehal_gauge/link.py").unlink()
    monkeypatch.setattr(_package, "MOST_FILES", 0)
    with pytest.raises(UsageError, match="more than 0 files"):
        add(made)


@pytest.mark.parametrize("name", ["tool.yaml", "folder"])
def test_a_device_and_any_other_file_belong_beside_the_description(name: str, tmp_path: Path) -> None:
    made = tmp_path / name
    made.mkdir() if name == "folder" else made.write_text("title: a device\n")
    with pytest.raises(UsageError, match=r"A plug-in is a folder with a pyproject\.toml") as refused:
        add(made)
    assert "belong beside the description" in refused.value.sentence


def test_a_name_or_a_module_of_another_plug_in_is_not_hidden(tmp_path: Path) -> None:
    add(GAUGE)
    with pytest.raises(UsageError, match="eehal-gauge has a codec gauge already"):
        add(package(tmp_path, WHEEL["scale.py"], points=CODEC + 'gauge = "scale:codec"\n'))
    files = {name: text.replace("scale:", "eehal_gauge:") for name, text in WHEEL.items()}
    with pytest.raises(UsageError, match="There is a module eehal_gauge already"):
        add(wheel(tmp_path, {**files, "eehal_gauge.py": ""}))


def test_a_broken_one_is_listed_and_stops_nobody_else(tmp_path: Path, folder: Path) -> None:
    add(GAUGE)
    add(wheel(tmp_path, WHEEL))
    (folder / "eehal-scale/scale.py").write_text("raise SystemExit('broken')")
    (folder / "empty").mkdir()
    good, bad, empty = sorted(
        added(), key=lambda each: ("eehal-gauge", "eehal-scale", "empty").index(each.name)
    )
    assert good.fault == ""
    assert "cannot be loaded: SystemExit: broken" in bad.fault
    assert empty.fault == "This folder is no plug-in: remove it."
    assert get_codec("gauge").name == "gauge"
    assert get_codec("ees1-ascii").name == "ees1-ascii"


def test_the_list_says_that_an_upgrade_has_brought_another_version(tmp_path: Path, folder: Path) -> None:
    add(package(tmp_path, WHEEL["scale.py"], needs='"click>=8", "numpy>=3; python_version<\'3\'"'))
    (found,) = added()
    assert found.fault == ""
    (about,) = folder.rglob("METADATA")
    about.write_text(about.read_text().replace("click>=8", "click<8"))
    (found,) = added()
    assert found.fault == f"It needs click<8, and {CLICK} is installed."


@pytest.mark.parametrize(
    ("wanted", "met"),
    [
        ("pack[fast] >=2, <3", True), ("pack ~=2.0", True), ("pack (>=2.2)", False), ("pack >=2.1", True),
        ("pack >=9; python_version < '3'", True), ("pack >=9; extra == 'fast'", True),
        ("pack >=9; python_version > '3'", False),
    ],
)  # fmt: skip
def test_a_requirement_is_met_by_the_version_that_is_installed(
    wanted: str, met: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_requirement, "version_of", lambda _: "2.1")
    assert (unmet([wanted]) == "") is met


@pytest.mark.parametrize("clause", ["===2", ">=two", "2", ">=" + "1" * 200, "; nothing == 'here'"])
def test_what_cannot_be_compared_is_refused(clause: str) -> None:
    assert unmet([f"click {clause}"])


def test_a_later_product_that_has_the_same_name_wins_and_the_list_says_so(
    tmp_path: Path, folder: Path
) -> None:
    add(wheel(tmp_path, WHEEL))
    (points,) = folder.rglob("entry_points.txt")
    points.write_text("[end_effector_hal.codecs]\nees1-ascii = scale:codec\n")
    (found,) = added()
    assert found.fault == "end-effector-hal has codec ees1-ascii of its own."


def test_what_it_prints_is_no_answer(tmp_path: Path) -> None:
    made = package(tmp_path, f"print({json.dumps('{}')})\nimport nowhere")
    with pytest.raises(UsageError, match="nowhere"):
        add(made)
