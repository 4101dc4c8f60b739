"""The network with sensors that are free: any reading changes to anything at any time, and remembers nothing."""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_hal.errors import UsageError
from timed_automata import Network

FREE_SENSORS: Mapping[str, tuple[str, ...]] = {
    "actuators": ("FREE_SENSORS",),
    "all": ("FREE_SENSORS", "FREE_TOOL"),
}
"""Constants of the UPPAAL file that set sensors free, by whose sensors they are: ``all`` has the tool changer's too."""


def free_constants(network: Network, which: str) -> dict[str, bool]:
    """Constants that set sensors free, to be put into the file of a network.

    Args:
        network: as its file or its description has it.
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
