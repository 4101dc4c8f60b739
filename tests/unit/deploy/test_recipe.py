"""The recipe of the image and the script that builds it, without building anything."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.places import DEPLOY

CONTAINER = DEPLOY / "container"
RECIPE = (CONTAINER / "Containerfile").read_text().replace("\\\n", " ")
STAGES = re.split(r"^FROM ", RECIPE, flags=re.MULTILINE)[1:]


def build_image(folder: Path, programs: dict[str, str], *arguments: str) -> subprocess.CompletedProcess[str]:
    """The script, on a machine that has these programs (their text, for sh) and a few of Debian's."""
    for name in ("bash", "cat", "dirname", "env", "head", "mktemp", "rm", "sh", "timeout"):
        found = shutil.which(name)
        assert found, name
        (folder / name).symlink_to(found)
    for name, text in programs.items():
        (folder / name).write_text(f"#!/bin/sh\n{text}\n")
        (folder / name).chmod(0o755)
    env = {"PATH": str(folder), "HOME": os.environ.get("HOME", "/"), "ROS": os.environ.get("ROS", "1")}
    script = CONTAINER / "image.sh"
    return subprocess.run(
        [script, *arguments], env=env, capture_output=True, text=True, timeout=60, check=False
    )


AMD64 = {"dpkg": "echo amd64"}
TOOLS = AMD64 | {"buildah": "exit 0", "mmdebstrap": "exit 0"}


@pytest.mark.parametrize(
    ("programs", "arch", "code", "sentence"),
    [
        (AMD64, "amd64", 3, "buildah is missing; on Debian 12: apt install buildah mmdebstrap uidmap"),
        (
            AMD64 | {"buildah": "exit 0"},
            "amd64",
            3,
            "mmdebstrap is missing; on Debian 12: apt install buildah mmdebstrap uidmap",
        ),
        (
            TOOLS,
            "arm64",
            3,
            "Programs for arm64 do not run here; on Debian 12: apt install qemu-user-static binfmt-support arch-test",
        ),
        (TOOLS, "armhf", 2, "ARCH is amd64 or arm64, not armhf: for others there are no Python wheels"),
    ],
    ids=["no buildah", "no mmdebstrap", "no qemu", "no wheels"],
)
def test_what_is_missing_is_one_line_with_its_package(
    tmp_path: Path, programs: dict[str, str], arch: str, code: int, sentence: str
) -> None:
    ended = build_image(tmp_path, programs, arch)
    assert (ended.returncode, ended.stdout, ended.stderr) == (code, "", f"{sentence}\n")


def test_there_is_no_image_with_ros_2_for_the_board(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS", "2")
    ended = build_image(tmp_path, TOOLS, "arm64")
    assert (ended.returncode, "no wheels of ROS 2 for arm64" in ended.stderr) == (2, True)


def test_the_packages_of_those_lines_are_what_make_installs() -> None:
    lists = {path.name: path.read_text().split() for path in CONTAINER.glob("host-packages*.txt")}
    assert lists == {
        "host-packages.txt": ["buildah", "mmdebstrap", "uidmap"],
        "host-packages-emulated.txt": ["arch-test", "binfmt-support", "qemu-user-static"],
    }


def test_each_stage_is_for_its_machine(tmp_path: Path) -> None:
    """The script tells the recipe the architectures: of the root, of the build stage, of the wheels."""
    say = f'[ "$1" != images ] || echo 1\nfor word in "$@"; do echo "$word" >>{tmp_path}/told; done'
    ended = build_image(tmp_path, TOOLS | {"buildah": say, "arch-test": "exit 0"}, "arm64")
    assert ended.returncode == 0, ended.stderr
    told = (tmp_path / "told").read_text().splitlines()
    given = dict(word.split("=", 1) for word in told if re.match(r"[A-Z_]+=", word))
    assert given == {
        "BASE": "localhost/eehal-debian:bookworm-arm64",
        "BUILD_BASE": "localhost/eehal-debian:bookworm-amd64",
        "TARGETARCH": "arm64",
        "ROS": "1",
        "BUILDPLATFORM": "linux/amd64",
        "TARGETPLATFORM": "linux/arm64",
    }
    assert set(given) <= set(re.findall(r"\b[A-Z_]{3,}\b", RECIPE))
    assert told[told.index("--arch") + 1] == "arm64"
    assert [stage.split()[1] for stage in STAGES] == ["${BUILD_BASE}", "${BASE}"]


def test_the_image_runs_as_a_user_of_its_own_in_the_groups_of_torizon() -> None:
    last = STAGES[-1]
    assert re.findall(r"^USER (\S+)", last, flags=re.MULTILINE)[-1] == "eehal"
    for words in (
        "groupadd --system --gid 49 gpio",
        "groupadd --system --gid 20 dialout",
        "--gid gpio --groups dialout",
    ):
        assert words in last
    assert "HEALTHCHECK" in last


def test_what_the_recipe_copies_reaches_the_build() -> None:
    """The ignore file names what goes in; a file that the build script reads must be in it."""
    kept = {
        line[1:] for line in (CONTAINER / "Containerfile.dockerignore").read_text().split() if line[0] == "!"
    }
    copied = {
        word
        for line in re.findall(r"^COPY (?!--from)(.*) \S+$", RECIPE, flags=re.MULTILINE)
        for word in line.split()
    }
    build = (DEPLOY / "build.sh").read_text()
    read = set(re.findall(r"(?:docs/[\w/-]+\.md|SAFETY\.md|pyproject\.toml)", build))
    for path in (copied | read | {"src", "ros", "uv.lock"}) - {"."}:
        assert any(path == each or path.startswith(f"{each}/") for each in kept), path
        assert (DEPLOY.parent / path).exists()
