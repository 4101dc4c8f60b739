"""How the kernel of these tests is made: its source must be the one that was patched, its name says all of it."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent
MADE_OF = ("kernel.fragment", "kernel.patch", "compile-kernel.sh")
PATCHED = ("arch/um/drivers/ssl.c", "arch/um/include/asm/irq.h", "arch/x86/um/user-offsets.c")
MAKE_WAS_CALLED = 42


class Recipe:
    """A copy of the scripts, on a machine whose other programs are stand-ins."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.cache = folder / "tests" / "acceptance" / "gpiochip", folder / "cache"
        shutil.copytree(HERE, self.folder, ignore=shutil.ignore_patterns("__pycache__"))
        self.programs = folder / "bin"
        self.programs.mkdir()
        for name, does in (
            ("uname", "echo x86_64"),
            ("dpkg-query", "printf 6.1-1"),
            ("make", f"exit {MAKE_WAS_CALLED}"),
        ):
            (self.programs / name).write_text(f"#!/bin/sh\n{does}\n")
            (self.programs / name).chmod(0o755)

    def run(self, script: str, *arguments: str, **env: str) -> subprocess.CompletedProcess[str]:
        env |= {"PATH": f"{self.programs}:{os.environ['PATH']}", "XDG_CACHE_HOME": str(self.cache)}
        return subprocess.run(
            [self.folder / script, *arguments], env=env, capture_output=True, text=True, check=False
        )

    def compile(self, source: Path) -> subprocess.CompletedProcess[str]:
        """From the folder ``source``, packed as Debian does."""
        packed, work = source.parent / "source.tar", source.parent / "work"
        work.mkdir()
        subprocess.run(["tar", "-C", source.parent, "-cf", packed, source.name], check=True)
        return self.run("compile-kernel.sh", str(work), str(work / "kernel"), LINUX_SOURCE=str(packed))


@pytest.fixture
def recipe(tmp_path: Path) -> Recipe:
    return Recipe(tmp_path)


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """What the patch expects of the kernel's source: its context, and the lines that it removes."""
    folder = tmp_path / "linux-source-6.1"
    for part in (HERE / "kernel.patch").read_text().split("\n--- a/")[1:]:
        name, _, hunk = part.partition("\n")
        before = [line[1:] for line in hunk.split("\n") if line.startswith((" ", "-"))]
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(before) + "\n")
    return folder


def test_the_source_that_the_patch_was_written_for_is_built(recipe: Recipe, source: Path) -> None:
    done = recipe.compile(source)
    assert done.returncode == MAKE_WAS_CALLED, done.stdout + done.stderr


@pytest.mark.parametrize("name", PATCHED)
def test_a_source_with_another_text_is_refused(recipe: Recipe, source: Path, name: str) -> None:
    text = (source / name).read_text()
    (source / name).write_text(
        text.replace("line_throttle", "n").replace("2696", "n").replace("UM_LAST", "n")
    )
    assert (source / name).read_text() != text
    done = recipe.compile(source)
    assert done.returncode == 1
    assert name in done.stdout
    assert "FAILED" in done.stdout


@pytest.mark.parametrize("changed", [None, *MADE_OF])
def test_a_kernel_is_found_only_if_it_was_made_of_the_same(recipe: Recipe, changed: str | None) -> None:
    made_of = b"".join((recipe.folder / name).read_bytes() for name in MADE_OF)
    kernel = recipe.cache / f"end-effector-hal/uml/linux-6.1-1-{hashlib.sha256(made_of).hexdigest()[:12]}"
    kernel.parent.mkdir(parents=True)
    kernel.touch(mode=0o755)
    if changed:
        with (recipe.folder / changed).open("a") as file:
            file.write("\n")
    found = recipe.run("build-kernel.sh", "find")
    assert (found.returncode, found.stdout) == ((1, "") if changed else (0, f"{kernel}\n"))


def test_there_is_room_for_the_floating_point_state_of_amx() -> None:
    """Linux' ``fpu_user_cfg.max_size``: 2,696 bytes with AVX-512 and PKRU, 11,008 with AMX."""
    patch = (HERE / "kernel.patch").read_text()
    size = int(patch.split("+\tDEFINE_LONGS(HOST_FP_SIZE, ")[1].split(")")[0])
    assert size >= 11_008
    assert size % 8 == 0
    # it stands at the bottom of each kernel stack, of 16 kB by default
    assert "CONFIG_KERNEL_STACK_ORDER=4\n" in (HERE / "kernel.fragment").read_text()
