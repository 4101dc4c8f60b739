"""The network with free sensors: any reading may change to any value at any time, without memory."""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_hal.errors import UsageError
from timed_automata import Network

FREE_SENSORS: Mapping[str, tuple[str, ...]] = {
    "actuators": ("FREE_SENSORS",),
    "all": ("FREE_SENSORS", "FREE_TOOL"),
}
"""Constants of the UPPAAL file that set sensors free, by the affected sensors: ``all`` includes those of the tool
changer.
"""


def free_constants(network: Network, which: str) -> dict[str, bool]:
    """Return the constants of a network's file that set its sensors free.

    Args:
        network: as its file or its description defines it.
        which: a key of `FREE_SENSORS`.

    Raises:
        UsageError: the file does not declare them.
    """
    names = FREE_SENSORS[which]
    if missing := [name for name in names if name not in network.constants]:
        raise UsageError(
            f"These automata declare no constant {' and no '.join(missing)}: their sensors cannot be set free.",
            where=network.document.path,
            todo="Leave out --free-sensors, or declare and use it as the shipped file does.",
        )
    return dict.fromkeys(names, True)
