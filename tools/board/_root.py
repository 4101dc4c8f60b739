"""The files of the emulated board: its root file system is in memory and is filled at its start."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping
from importlib.metadata import distribution
from pathlib import Path

from end_effector_hal.errors import RosError

from ._cpio import write_archive
from ._parts import DISTRIBUTION

HERE = Path(__file__).parent
PACKAGES = [
    HERE.parents[1] / "src" / name for name in ("timed_automata", "end_effector_hal", "end_effector_lab")
]
HOME = Path("opt/end-effector")
"""Folder of the project on the board."""
EEHAL = "#!/usr/bin/env python3\nfrom end_effector_hal.cli import main\n\nmain()\n"
DEMO = "#!/usr/bin/env python3\nfrom end_effector_lab.commands._demo import command\n\ncommand()\n"
"""`eehal demo` itself needs the extra `lab`, and the board has no matplotlib."""
ROS_PACKAGES = ("end_effector_msgs", "end_effector_hal")
SEED_BYTES = 64


def write_root(parts: Path, place: Path, job: str, files: Mapping[str, str], *, ros: bool) -> Path:
    """Write an archive of the built parts, the present project, and the job.

    Args:
        parts: see `board_parts`.
        place: folder for the archive.
        job: bash script.
        files: text of more files, by their path on the board.
        ros: whether to include the nodes and their messages.

    Raises:
        RosError: ROS is requested and missing.
    """
    more = place / "more"
    site = more / HOME / "site"
    ignore = shutil.ignore_patterns("__pycache__")
    for package in PACKAGES:
        shutil.copytree(package, site / package.name, ignore=ignore)
    _write_metadata(site)
    if ros:
        shutil.copytree(_messages(), site / ROS_PACKAGES[0], ignore=ignore)
        for name in ROS_PACKAGES:
            shutil.copytree(_ros_package(name), more / HOME / "ros" / name, ignore=ignore)
    own = {
        "init": (HERE / "init.sh").read_text(),
        "job": job,
        "usr/bin/eehal": EEHAL,
        "usr/bin/eehal-demo": DEMO,
        "date": f"{time.time():.0f}",
    }
    for name, content in {**own, **files}.items():
        path = more / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
        path.chmod(0o755)
    (more / "seed").write_bytes(os.urandom(SEED_BYTES))
    if sys.version_info[:2] == (3, 11):  # the board's: it need not compile
        subprocess.run([sys.executable, "-m", "compileall", "-q", "-s", more, more / HOME], check=True)
    root = place / "root.cpio"
    with root.open("wb") as file, (parts / "root.cpio").open("rb") as built:
        shutil.copyfileobj(built, file, 1 << 20)
        write_archive(more, file)
    shutil.rmtree(more)
    return root


def _write_metadata(site: Path) -> None:
    """Write the entry points by which `eehal` finds the commands of the development tools."""
    own = distribution(DISTRIBUTION)
    place = site / f"{DISTRIBUTION.replace('-', '_')}-{own.version}.dist-info"
    place.mkdir()
    for name in ("METADATA", "entry_points.txt"):
        (place / name).write_text(own.read_text(name) or "", encoding="utf-8")


def _messages() -> Path:
    found = importlib.util.find_spec(ROS_PACKAGES[0])
    if found is None or not found.submodule_search_locations:
        raise _no_ros("The ROS messages are not built, or not sourced.")
    return Path(found.submodule_search_locations[0])


def _ros_package(name: str) -> Path:
    for folder in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        for place in (Path(folder), Path(folder) / name):
            if place.name == name and (place / "CMakeLists.txt").exists():
                return place
    raise _no_ros(f"The ROS package {name} is not in ROS_PACKAGE_PATH.")


def _no_ros(what: str) -> RosError:
    return RosError(
        what,
        todo="`make setup`, then `. build/catkin/devel/setup.sh`; `make board` does both. Without ROS: --no-ros.",
    )
