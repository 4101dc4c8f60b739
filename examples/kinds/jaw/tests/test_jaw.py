"""A jaw does what every kind of device must do; its physics and its codec too."""

from typing import ClassVar

from eehal_jaw import Jaw
from eehal_jaw.codec import JawLine
from eehal_jaw.physics import JawPhysics

from end_effector_hal.codecs.conformance import CodecConformance
from end_effector_hal.kinds.conformance import KindConformance
from end_effector_hal.signals import Frame
from end_effector_lab.testbench.physics.conformance import PhysicsConformance


class TestJaw(KindConformance):
    kind = Jaw()
    stanza: ClassVar = {"line": "JAW"}
    active: ClassVar = {"jaw_closed": True, "jaw_open": False}
    inactive: ClassVar = {"jaw_closed": False, "jaw_open": True}


class TestJawPhysics(PhysicsConformance):
    kind = Jaw()
    physics = JawPhysics
    stanza: ClassVar = {"line": "JAW"}


class TestJawLine(CodecConformance):
    codec = JawLine()
    vectors = ((b"$SW,1*D480\r\n", Frame(0, None, None, {"jaw_closed": True, "jaw_open": False})),)
