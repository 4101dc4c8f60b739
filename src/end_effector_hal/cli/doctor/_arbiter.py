"""Checks the line arbiter: whether one serves the socket of the tool, which clients it has, and which lines are
active.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import ReportedError
from end_effector_hal.wires import holders_of

from ._check_result import CheckedPart, CheckResult, CheckResults

_FOLDERS = (Path("/run/eehal"), Path(f"/run/user/{os.getuid()}/eehal"), Path("/tmp/eehal-0"))
_START = "Start it: eehal arbiter DESCRIPTION, or systemctl start eehal-arbiter@TOOL."
_GROUP = "Add the user to the group gpio, which owns the socket, and log in again."
_FRESH_US = 1_000_000
"""Largest age of a sensor predicate that counts as fresh, µs. It is longer than the 150 ms of the arbiter itself: the
machine may be slow, and reading changes nothing.
"""
_say = CheckedPart("arbiter")


def look_at_arbiter(description: Description, lines: tuple[str, ...]) -> CheckResults:
    """Read levels, status and records without writing anything; ``lines`` are all output lines of the tool."""
    from end_effector_hal.arbiter import DROP_FIRST, ArbiterClient, arbiter_policy, recorded_left_behind

    try:
        path = socket_path(description)
    except ReportedError as error:
        yield _say.missing(f"{error.where}: {error.what}", error.todo)
        return
    policy = arbiter_policy(description)
    if forgotten := recorded_left_behind(path, policy):
        yield _say.missing(forgotten.rstrip("."), DROP_FIRST)
    try:
        with ArbiterClient(path, "doctor", patience_s=0) as client:
            levels, status = client.levels(), client.status()
    except ReportedError as error:
        yield _unreachable(path, error)
        return
    owned = status.get("lines", list(levels))
    if set(owned) != set(lines):
        yield _say.missing(
            f"pid {status.get('pid')} at {path} owns other lines: {', '.join(owned)}",
            "It was started with another description: stop it and start it with this one.",
        )
        return
    yield _say.ok(f"pid {status.get('pid')} serves {path}; {_clients(status)}")
    active = [policy.called(line) for line, level in levels.items() if level]
    unknown = [policy.called(line) for line in status.get("may_be_active", ()) if not levels.get(line)]
    more = f"; position not known: {', '.join(unknown)}" if unknown else ""
    yield _say.ok(f"active: {', '.join(active) or 'no line'}{more}")
    yield from _sensed(status)
    if trips := status.get("trips"):
        yield _say.warning(
            f"{len(trips)} activations were ended after their longest time, the last of {trips[-1].get('line')}",
            "The program that began it should end it earlier; see the log of the arbiter.",
        )


def _sensed(status: dict[str, Any]) -> Iterator[CheckResult]:
    """Report what the sensors prove to the arbiter (IL-01, IL-05, IL-13), and the faults of the arbiter."""
    needs, told = status.get("needs", []), status.get("told", {})
    fresh = {name: told[name]["holds"] for name in needs if name in told and told[name]["age_us"] < _FRESH_US}
    missing = [name for name in needs if name not in fresh]
    if missing and status.get("clients"):
        yield _say.warning(
            f"no process reports what the sensors show ({', '.join(missing)}): activations are refused",
            "The HAL (HALMain, eehal serve, eehal run) reads the sensor link and reports to the arbiter.",
        )
    elif fresh:
        shown = ", ".join(f"{name} {'yes' if holds else 'no'}" for name, holds in fresh.items())
        yield _say.ok(f"by the sensors: {shown}")
    for why in status.get("faults", {}).values():
        yield _say.warning(f"latched: {why}", "Remove the cause, then reset the faults.")


def _clients(status: dict[str, Any]) -> str:
    clients = [
        f"{each.get('client')} ({_process(each)}{', its last will is being executed' if each.get('ended') else ''})"
        for each in status.get("clients", [])
    ]
    return f"writing: {', '.join(clients)}" if clients else "no program writes"


def _process(client: dict[str, Any]) -> str:
    return f"pid {client['pid']}" if client.get("pid") else "in another container"


def _unreachable(path: Path, error: ReportedError) -> CheckResult:
    if path.parent.is_dir() and not os.access(path.parent, os.X_OK):
        return _say.missing(f"{path.parent} may not be entered: permission denied", _GROUP)
    if isinstance(error.__cause__, PermissionError):
        return _say.missing(f"{path} may not be opened: permission denied", _GROUP)
    if holders := " and ".join(map(str, holders_of(f"{path}.lock"))):
        return _say.missing(
            f"{path} is held by {holders}: {error.what}",
            "If it does not answer any more, stop it and start it again; it adopts the lines as they are.",
        )
    if elsewhere := next(_elsewhere(path), None):
        return _say.missing(
            f"no line arbiter at {path}, but there is a socket at {elsewhere}",
            f"Set EEHAL_RUN_DIR={elsewhere.parent}, like the arbiter.",
        )
    return _say.missing(f"no line arbiter runs at {path}", _START)


def _elsewhere(path: Path) -> Iterator[Path]:
    """Yield sockets of the same name in the folders that programs of other users use."""
    for folder in _FOLDERS:
        try:
            if folder != path.parent and (folder / path.name).is_socket():
                yield folder / path.name
        except OSError:
            continue
