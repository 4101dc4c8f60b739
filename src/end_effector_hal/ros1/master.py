"""Access to the ROS master by XML-RPC, with the time-outs that ROS's own library lacks, and a watch whether it runs.

It needs no package of ROS.
"""

from __future__ import annotations

import http.client
import os
import threading
import xmlrpc.client
from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit
from xml.parsers.expat import ExpatError

from end_effector_hal.errors import RosError

CALLER = "/end_effector_hal"
TIMEOUT_S = 2.0

NoSuchMethod = xmlrpc.client.Fault
"""The error that :func:`ask_node` raises for a method that the node does not have."""


def master_uri() -> str:
    """Return the address of the master; raises RosError if the variable is missing or is not a URI."""
    uri = os.environ.get("ROS_MASTER_URI", "")
    if not uri:
        raise RosError(
            "ROS_MASTER_URI is not set.", todo="Source the workspace: . build/catkin/devel/setup.sh"
        )
    try:
        valid = urlsplit(uri).scheme == "http" and urlsplit(uri).port is not None
    except ValueError:
        valid = False
    if not valid:
        raise RosError(f"ROS_MASTER_URI is no address: {uri!r}.", todo="Such as http://localhost:11311.")
    return uri


def ask_pid() -> int:
    """Return the process id of the master, which changes with a restart; raises RosError when it cannot be reached."""
    pid = ask_master("getPid")
    if not isinstance(pid, int):
        raise RosError(f"The program at {master_uri()} is no ROS master.")
    return pid


def ask_master(method: str, *arguments: str) -> Any:
    """Return the answer of the master; None: it has no such entry. Raises RosError when it cannot be reached."""
    uri = master_uri()
    try:
        return ask_node(uri, method, *arguments)
    except (OSError, xmlrpc.client.Error) as error:
        why = "it does not answer" if isinstance(error, TimeoutError) else str(error)
        raise RosError(
            f"The ROS master at {uri} cannot be reached ({why}).",
            todo="Start roscore, or use roslaunch.",
        ) from None


def ask_node(uri: str, method: str, *arguments: str) -> Any:
    """Return the answer of a node within 2 s; None: it refuses.

    Raises:
        TimeoutError: the node does not answer.
        OSError: there is no node at this address.
        NoSuchMethod: it does not have this method.
    """
    try:
        with xmlrpc.client.ServerProxy(uri, transport=_Transport()) as proxy:
            code, _, value = getattr(proxy, method)(CALLER, *arguments)
    except (
        http.client.HTTPException,
        xmlrpc.client.ProtocolError,
        ExpatError,
        ValueError,
        TypeError,
    ) as error:
        raise ConnectionError(str(error) or type(error).__name__) from None
    return value if code == 1 else None


class _Transport(xmlrpc.client.Transport):
    def make_connection(self, host: tuple[str, dict[str, str]] | str) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT_S
        return connection


POLL_S = 1.5
MISSES = 2
"""Number of consecutive polls without an answer after which the master counts as gone (3 to 7 s)."""


class MasterWatch:
    """Reports once that the master is gone or was restarted, because a node does not register again by itself.

    Args:
        on_gone: called with a sentence, in the thread of the watch.
    """

    def __init__(self, on_gone: Callable[[str], None]) -> None:
        self._on_gone, self._pid = on_gone, ask_pid()
        self._end = threading.Event()
        threading.Thread(target=self._run, name="master watch", daemon=True).start()

    def close(self) -> None:
        """Stop the polls."""
        self._end.set()

    def _run(self) -> None:
        missed = 0
        while missed < MISSES and not self._end.wait(POLL_S):
            try:
                if ask_pid() != self._pid:
                    self._on_gone("The ROS master was started again; this node is not registered there.")
                    return
                missed = 0
            except RosError as error:
                missed += 1
                if missed == MISSES:
                    self._on_gone(str(error))
