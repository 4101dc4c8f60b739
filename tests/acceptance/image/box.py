"""A container of the image, by buildah alone: its user, its groups, no capability; no container runtime is needed."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from end_effector_lab.processes import Child, Children

ISOLATION = os.environ.get("BUILDAH_ISOLATION", "chroot")


def buildah(*arguments: str, timeout_s: float = 120.0) -> str:
    """What a command of buildah prints."""
    done = subprocess.run(
        ["buildah", *arguments], capture_output=True, text=True, timeout=timeout_s, check=False
    )
    assert done.returncode == 0, f"buildah {' '.join(arguments)}: {done.stderr}"
    return done.stdout.strip()


class Box:
    """Runs programs in one container; they see its files, ``/bench``, and the wires in it.

    Args:
        image: of buildah's storage.
        bench: folder of the host that is ``/bench`` in there.
        env: added to what the image sets.
        limit_s: the longest that one command may take.
    """

    def __init__(self, image: str, bench: Path, env: Mapping[str, str], *, limit_s: float) -> None:
        self._bench, self._env, self.limit_s = bench, env, limit_s
        self.children = Children()
        self._name = buildah("from", "--pull=never", image)
        self.config: dict[str, Any] = json.loads(buildah("inspect", self._name))["Docker"]["config"]

    def _command(self, words: tuple[str, ...], env: Mapping[str, str] | None) -> list[str]:
        # the mark by which what runs in there is found, and ended
        given = {**self._env, **(env or {}), "EEHAL_DEMO": self.children.env["EEHAL_DEMO"]}
        options = [f"--env={name}={value}" for name, value in given.items()]
        isolated = ["--isolation", ISOLATION, "--cap-drop=all", f"--volume={self._bench}:/bench"]
        # a user of the image's own choice: none is named here
        return ["buildah", "run", *isolated, *options, self._name, "--", *words]

    def run(self, *words: str, env: Mapping[str, str] | None = None) -> subprocess.CompletedProcess[str]:
        """A command, to its end."""
        return subprocess.run(
            self._command(words, env), capture_output=True, text=True, timeout=self.limit_s, check=False
        )

    def start(self, name: str, *words: str, env: Mapping[str, str] | None = None) -> Child:
        """A process that goes on; its log stands in the bench's folder."""
        log = self._bench.parent / f"{name}.log"
        return self.children.start(name, self._command(words, env), log=log, patience_s=10.0)

    def end(self) -> None:
        """End all of it, and forget what it has written."""
        self.children.end()
        buildah("rm", self._name)
