"""The kinds of this product do what every kind must do, in words, in proof and in the lab."""

from __future__ import annotations

import tomllib
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path
from typing import ClassVar

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import DeviceKind, _registry, get_kind, kind_names, recorded_kind, usable_kinds
from end_effector_hal.kinds.conformance import KindConformance
from end_effector_hal.kinds.cylinder import Cylinder, CylinderState
from end_effector_hal.kinds.gripper import Gripper
from end_effector_hal.kinds.magnet import Magnet
from end_effector_hal.kinds.vacuum import Vacuum, VacuumState
from end_effector_lab.testbench.physics import Cylinder as CylinderPhysics
from end_effector_lab.testbench.physics import Fingers, HoldingMagnet, VacuumCircuit, physics_of
from end_effector_lab.testbench.physics import _device as physics_registry
from end_effector_lab.testbench.physics.conformance import PhysicsConformance


class TestVacuum(KindConformance):
    kind = Vacuum()
    stanza: ClassVar = {"line": "A", "channel": "cup"}
    active: ClassVar = {"cup": -80_000}
    inactive: ClassVar = {"cup": 0}


class TestVacuumSwitch(KindConformance):
    kind = Vacuum()
    stanza: ClassVar = {"line": "A", "channel": "cup"}
    active: ClassVar = {"cup": True}
    inactive: ClassVar = {"cup": False}


class TestCylinder(KindConformance):
    kind = Cylinder()
    stanza: ClassVar = {"line": "A", "channel": "rod"}
    active: ClassVar = {"rod": 600_000, "cylinder_extended": True, "cylinder_retracted": False}
    inactive: ClassVar = {"rod": 0, "cylinder_extended": False, "cylinder_retracted": True}


class TestCylinderByItsBits(KindConformance):
    kind = Cylinder()
    stanza: ClassVar = {"line": "A", "channel": "none", "stroke_mm": 80.0}
    active: ClassVar = {"cylinder_extended": True, "cylinder_retracted": False}
    inactive: ClassVar = {"cylinder_extended": False, "cylinder_retracted": True}

    def test_its_stroke_is_metres_of_a_joint(self) -> None:
        assert self.kind.travel(self.actuator) == ("prismatic", 0.08)
        assert self.kind.travel(self.actuator.model_copy(update={"stroke_mm": None})) is None


class TestVacuumWithAPartSwitch(KindConformance):
    kind = Vacuum()
    stanza: ClassVar = {"line": "A", "channel": "none", "part_bit": "cup"}
    active: ClassVar = {"cup": True}
    inactive: ClassVar = {"cup": False}


class TestVacuumWithTwoSwitches(KindConformance):
    kind = Vacuum()
    stanza: ClassVar = {"line": "A", "channel": "none", "part_bit": "cup", "gone_bit": "vented"}
    active: ClassVar = {"cup": True, "vented": False}
    inactive: ClassVar = {"cup": False, "vented": True}


class TestGripperWithEndSwitches(KindConformance):
    kind = Gripper()
    stanza: ClassVar = {"line": "A", "open_bit": "opened", "closed_bit": "closed", "stroke_mm": 8.0}
    active: ClassVar = {"opened": False, "closed": False}
    inactive: ClassVar = {"opened": True, "closed": False}


class TestGripperWithAPartSwitch(KindConformance):
    kind = Gripper()
    stanza: ClassVar = {"line": "A", "part_bit": "part", "closed_bit": "none"}
    active: ClassVar = {"part": True}
    inactive: ClassVar = {"part": False}


class TestGripperWithAllSwitches(KindConformance):
    kind = Gripper()
    stanza: ClassVar = {"line": "A", "open_bit": "opened", "closed_bit": "closed", "part_bit": "part"}
    active: ClassVar = {"opened": False, "closed": False, "part": True}
    inactive: ClassVar = {"opened": True, "closed": False, "part": False}


class TestMagnet(KindConformance):
    kind = Magnet()
    stanza: ClassVar = {"line": "A", "part_bit": "part"}
    active: ClassVar = {"part": True}
    inactive: ClassVar = {"part": False}


class TestMagnetWithAProofOfRelease(KindConformance):
    kind = Magnet()
    stanza: ClassVar = {"line": "A", "part_bit": "part", "gone_bit": "away"}
    active: ClassVar = {"part": True, "away": False}
    inactive: ClassVar = {"part": False, "away": True}


class TestVacuumPhysics(PhysicsConformance):
    kind = Vacuum()
    physics = VacuumCircuit
    stanza: ClassVar = {"line": "A", "channel": "cup"}


class TestCylinderPhysics(PhysicsConformance):
    kind = Cylinder()
    physics = CylinderPhysics
    stanza: ClassVar = {"line": "A", "channel": "rod"}


class TestVacuumPhysicsWithSwitches(PhysicsConformance):
    kind = Vacuum()
    physics = VacuumCircuit
    stanza: ClassVar = {"line": "A", "channel": "none", "part_bit": "cup", "gone_bit": "vented"}


class TestFingers(PhysicsConformance):
    kind = Gripper()
    physics = Fingers
    stanza: ClassVar = {"line": "A", "open_bit": "opened", "closed_bit": "closed"}


class TestFingersWithAPartSwitch(PhysicsConformance):
    kind = Gripper()
    physics = Fingers
    stanza: ClassVar = {"line": "A", "part_bit": "part"}


class TestHoldingMagnet(PhysicsConformance):
    kind = Magnet()
    physics = HoldingMagnet
    stanza: ClassVar = {"line": "A", "part_bit": "part", "gone_bit": "away"}


def test_our_own_are_the_entry_points_of_this_distribution():
    points = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
    assert points[_registry.GROUP] == _registry.OWN
    assert points[physics_registry.GROUP] == physics_registry.OWN
    assert list(_registry.OWN) == list(physics_registry.OWN) == list(usable_kinds())
    for name in _registry.OWN:
        assert get_kind(name).name == name
        physics_of(name)


def test_the_words_of_a_recording_come_from_its_kinds_then_from_its_names():
    assert recorded_kind("grabber", {"grabber": "cylinder"}).states is CylinderState
    assert recorded_kind("left_cylinder", {}).states is CylinderState
    assert recorded_kind("left_cylinder", {"left_cylinder": "vacuum"}).states is VacuumState
    assert recorded_kind("grabber", {}).states is VacuumState


def test_an_unknown_kind_is_refused_with_the_known_ones():
    for asked in (get_kind, lambda name: recorded_kind("grabber", {"grabber": name})):
        with pytest.raises(
            UsageError,
            match=r"there is no kind of actuator 'crane'.*There are: vacuum, cylinder, gripper, magnet",
        ):
            asked("crane")
    with pytest.raises(
        UsageError, match=r"simulated kind of actuator 'crane'.*There are: vacuum, cylinder, gripper, magnet"
    ):
        physics_of("crane")


class Nameless(Vacuum):
    name = "No Name"


class Wordless(Vacuum):
    name = "wordless"


class Raises(Vacuum):
    def __init__(self) -> None:
        raise SystemExit("no")


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("Nameless", "the kind declares a name that is no word"),
        ("Wordless", 'a stanza whose kind is not Literal["wordless"]'),
        ("Raises", "cannot be loaded: SystemExit: no"),
        ("Path", "the kind declares no subclass of DeviceKind"),
        ("Vacuum", "names the kind vacuum"),
    ],
)
def test_what_is_no_kind_is_a_sentence_and_ends_nothing(
    monkeypatch: pytest.MonkeyPatch, value: str, why: str
) -> None:
    points = EntryPoints([EntryPoint("odd", f"{__name__}:{value}", _registry.GROUP)])
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **kw: points.select(**kw))
    assert kind_names() == ("vacuum", "cylinder", "gripper", "magnet", "odd")
    with pytest.raises(UsageError) as caught:
        get_kind("odd")
    assert why in caught.value.what
    assert list(usable_kinds(kind_names())) == ["vacuum", "cylinder", "gripper", "magnet"]


def test_a_kind_is_documented_rule_by_rule():
    rules = (DeviceKind.__doc__ or "").splitlines()
    assert [line.strip()[0] for line in rules if line.strip()[:1].isdigit()] == [*"123456789", "1", "1"]
