"""The ROS master: whether it is there, and whether it still is."""

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
POLL_S = 1.5
MISSES = 2
"""So many polls in a row without an answer: the master has gone (after 3 to 7 s)."""


class _Transport(xmlrpc.client.Transport):
    """A master that accepts and does not answer must not hold a node for ever."""

    def make_connection(self, host: tuple[str, dict[str, str]] | str) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT_S
        return connection


def master_uri() -> str:
    """Where the master is; raises RosError if the variable is missing or is no URI."""
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
    """The master's process, which tells one from the next; raises RosError when it cannot be reached."""
    pid = ask_master("getPid")
    if not isinstance(pid, int):
        raise RosError(f"What answers at {master_uri()} is no ROS master.")
    return pid


def ask_master(method: str, *arguments: str) -> Any:
    """What the master answers; None: it knows no such thing. Raises RosError when it cannot be reached."""
    uri = master_uri()
    try:
        return _ask(uri, method, *arguments)
    except (OSError, xmlrpc.client.Error) as error:
        why = "it does not answer" if isinstance(error, TimeoutError) else str(error)
        raise RosError(
            f"The ROS master at {uri} cannot be reached ({why}).",
            todo="Start roscore, or use roslaunch.",
        ) from None


def ask_node(uri: str, method: str) -> Any:
    """What a node answers, within 2 s, None: it refuses.

    Raises:
        TimeoutError: it does not answer.
        OSError: nobody is there, or it is no node.
        xmlrpc.client.Fault: it has no such method.
    """
    return _ask(uri, method)


def _ask(uri: str, method: str, *arguments: str) -> Any:
    try:
        proxy = xmlrpc.client.ServerProxy(uri, transport=_Transport())
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


class MasterWatch:
    """Says once when the master has gone or was started again: a node does not register again by itself.

    Args:
        on_gone: called with a sentence, in the thread of the watch.
    """

    def __init__(self, on_gone: Callable[[str], None]) -> None:
        self._on_gone, self._pid = on_gone, ask_pid()
        self._end = threading.Event()
        threading.Thread(target=self._run, name="master watch", daemon=True).start()

    def close(self) -> None:
        """No more polls."""
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
