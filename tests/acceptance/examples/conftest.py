"""A fresh environment, into which a package of somebody else's is installed beside this product."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
EEHAL = '#!/bin/sh\nexec "{python}" -c "from end_effector_hal.cli import main; main()" "$@"\n'


class Environment:
    """What a user has after `pip install '.[lab]'`; nothing comes from the network."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        venv.create(folder / "env", with_pip=False)
        self.bin = folder / "env" / "bin"
        (packages,) = (folder / "env" / "lib").glob("python*/site-packages")
        installed = [each for each in sys.path if each.endswith(("site-packages", "dist-packages"))]
        lines = "".join(f"import site; site.addsitedir({each!r})\n" for each in installed)
        (packages / "of_this_checkout.pth").write_text(lines, encoding="utf-8")
        eehal = self.bin / "eehal"
        eehal.write_text(EEHAL.format(python=self.bin / "python"), encoding="utf-8")
        eehal.chmod(0o755)
        os.symlink(ROOT / "examples", folder / "examples")

    def run(self, *words: object, expected: int = 0) -> subprocess.CompletedProcess[str]:
        """A command in the folder of the environment, as a user types it."""
        uv = str(ROOT / "build" / "uv" / "bin")
        own = {"VIRTUAL_ENV": str(self.folder / "env"), "UV_OFFLINE": "1", "PYTHONDONTWRITEBYTECODE": "1"}
        path = os.pathsep.join((str(self.bin), os.environ["PATH"], uv))
        done = subprocess.run(
            [*map(str, words)],
            cwd=self.folder,
            env=os.environ | own | {"PATH": path},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == expected, done.stdout + done.stderr
        return done


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    assert shutil.which("uv") or (ROOT / "build" / "uv" / "bin" / "uv").exists(), "make setup brings uv"
    return Environment(tmp_path_factory.mktemp("fresh"))
