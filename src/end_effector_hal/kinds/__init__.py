"""Kinds of devices, such as vacuum, cylinder and gripper: everything that differs between devices.

To add a kind, write a subclass of `DeviceKind` with a stanza of its keys, an entry point in the group
``end_effector_hal.kinds``, and a test that inherits `end_effector_hal.kinds.conformance.KindConformance`. To simulate
it, write its physics, with an entry point of the same name in ``end_effector_hal.physics``; `PhysicsConformance` tests
it.
"""

from end_effector_hal.signals import ChannelReadings

from ._guard import fault_of, is_guarded
from ._kind import DeviceKind
from ._parts import (
    COMPRESSED_AIR,
    ChannelKey,
    Detector,
    HoldFinding,
    HoldWatch,
    JointRule,
    LeakWatch,
    Pair,
    PressureRange,
    Quote,
    Travel,
    below_ambient_kpa,
)
from ._registry import (
    SwitchMeaning,
    confirmed_words,
    detector_of,
    get_kind,
    kind_names,
    kind_of,
    lost_words,
    present_words,
    recorded_kind,
    switch_meanings,
    usable_kinds,
)

__all__ = [
    "COMPRESSED_AIR",
    "ChannelKey",
    "ChannelReadings",
    "Detector",
    "DeviceKind",
    "HoldFinding",
    "HoldWatch",
    "JointRule",
    "LeakWatch",
    "Pair",
    "PressureRange",
    "Quote",
    "SwitchMeaning",
    "Travel",
    "below_ambient_kpa",
    "confirmed_words",
    "detector_of",
    "fault_of",
    "get_kind",
    "is_guarded",
    "kind_names",
    "kind_of",
    "lost_words",
    "present_words",
    "recorded_kind",
    "switch_meanings",
    "usable_kinds",
]
