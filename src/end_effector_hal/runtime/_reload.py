"""Decide whether a running program may adopt the current content of its description file (`eehal reload`).

Rule 1. The file is checked first. While it has a fault, the running description stays in force.

Rule 2. The configuration with which the line arbiter was started cannot change while it runs: outputs, their
interlocks, times and last wills, the inputs and buses that the arbiter reads itself, its socket. To change these,
restart the arbiter first; its lines keep their levels.

Rule 3. A description is adopted only at rest: in STAND_BY, with nothing held, no command and no maintenance. The
program checks this first; a held part must be dropped before.

Rule 4. A program that adopts the new description restarts, and adopts the lines as they are, as after any restart.
"""

from __future__ import annotations

from dataclasses import fields

from end_effector_hal.arbiter import Policy, arbiter_policy, recorded_left_behind
from end_effector_hal.codecs import load_tool
from end_effector_hal.control import Answer
from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import ReportedError

_OF_POLICY = {
    "lines": "the output lines",
    "exclusions": "which outputs exclude each other",
    "max_active_us": "the longest time of an output",
    "needs": "what the sensors must prove for an activation",
    "longest_last_will_us": "the longest last will (the sum of release_s)",
    "faults": "the latched faults",
    "labels": "the names of the outputs",
    "roles": "what each output drives",
    "opposites": "second coils and pulses",
    "release_us": "release_s of an actuator on a bus",
    "registers": "how many values an output on a bus has (command_on)",
    "proven": "the inputs that the line arbiter reads itself",
}
CONTENT = "The description is valid and can be loaded."


def reload_answer(before: Description) -> Answer:
    """Return whether the current file of a running description could be adopted (rules 1 and 2).

    The caller must check rule 3 first.
    """
    try:
        after = load_tool(before.source)
    except ReportedError as error:
        return Answer(False, f"{error}\nThe description that runs stays in force.")
    if why := recorded_left_behind(socket_path(before), arbiter_policy(after)):
        return Answer(False, f"{why} Drop first, or switch it off. The description that runs stays in force.")
    if kept := fixed_by_arbiter(before, after):
        what = ", ".join(kept)
        return Answer(
            False,
            f"Only a restart of the line arbiter can change {what}. The description that runs stays in force. End the "
            "programs, restart the line arbiter (its lines keep their levels), and start them again; with systemd: "
            "systemctl restart eehal-arbiter@TOOL eehal@TOOL.",
        )
    return Answer(True, CONTENT)


def fixed_by_arbiter(before: Description, after: Description) -> list[str]:
    """Return clauses about changed settings that need a restart of the line arbiter; empty if there are none."""
    old, new = arbiter_policy(before), arbiter_policy(after)
    found = [
        _OF_POLICY.get(field.name, field.name)
        for field in fields(Policy)
        if getattr(old, field.name) != getattr(new, field.name)
    ]
    if socket_path(before) != socket_path(after):
        found.append("its socket (the name of the tool, or lines: socket)")
    if before.lines != after.lines:
        found.append("lines")
    if _read_by_arbiter(before) != _read_by_arbiter(after):
        found.append("the inputs and buses that it reads itself")
    return found


def _read_by_arbiter(description: Description) -> object:
    inputs = {name: description.channels[name] for name in sorted(description.arbiter_inputs)}
    links = {name: description.links[name] for name in sorted(description.buses)}
    over = {name: description.channels_over(name) for name in links}
    return inputs, description.inputs if inputs else None, description.buses, links, over
