"""A ROS master of one's own, so that nothing else of ROS on this machine is touched."""

from __future__ import annotations

import os
import signal
import socket
import sys
from contextlib import suppress
from pathlib import Path

from end_effector_hal.errors import RosError

from ._child import Child
from ._children import Children

LOOPBACK = "127.0.0.1"


class Master:
    """On a free port of the loopback.

    Args:
        logs: a folder for the logs of ROS; it is made.

    Attributes:
        env: what its nodes need in their environment.
    """

    def __init__(self, logs: Path) -> None:
        logs.mkdir(parents=True, exist_ok=True)
        self._port = free_port()
        self.env = {
            "ROS_MASTER_URI": f"http://{LOOPBACK}:{self._port}",
            "ROS_IP": LOOPBACK,
            "ROS_LOG_DIR": str(logs.absolute()),
            "PYTHONUNBUFFERED": "1",
            # the nodes ask `env` for python3: it is to be this one
            "PATH": f"{Path(sys.executable).parent}:{os.environ.get('PATH', os.defpath)}",
        }

    def start(self, children: Children, log: Path, *, patience_s: float) -> Child:
        """A roscore that answers.

        Raises:
            RosError: it did not within ``patience_s``; with the last lines of its log.
        """
        command = ["roscore", "-p", str(self._port)]
        child = children.start(
            "roscore", command, log=log, failed=RosError, env=self.env, end_by=signal.SIGINT
        )
        child.wait_until(self._answers, timeout_s=patience_s, what="it answered")
        return child

    def _answers(self) -> bool:
        with suppress(OSError), socket.create_connection((LOOPBACK, self._port), timeout=0.5):
            return True
        return False


def free_port() -> int:
    """One of the loopback that nobody has now."""
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])
