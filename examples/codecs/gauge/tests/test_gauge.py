"""The gauge does what every polled codec must do."""

from eehal_gauge import gauge

from end_effector_hal.codecs.polled_conformance import PolledCodecConformance
from end_effector_hal.signals import Frame


class TestGauge(PolledCodecConformance):
    codec = gauge
    vectors = (
        (
            ((bytes.fromhex("05 03 01 00 00 01 84 72"), bytes.fromhex("05 03 02 e5 0c 03 11")),),
            Frame(0, None, None, {"cup": -69_000}),
        ),
    )
