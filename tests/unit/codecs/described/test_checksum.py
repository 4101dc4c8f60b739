"""The checksums by the check values of their catalogues: what they make of 123456789."""

import pytest

from end_effector_hal.codecs.described._field import CHECKSUMS

CHECK = {
    "none": 0,
    "xor8": 0x31,
    "sum8": 0xDD,
    "crc8": 0xF4,
    "crc16-modbus": 0x4B37,
    "crc16-ccitt": 0x29B1,
    "crc32": 0xCBF43926,
}


@pytest.mark.parametrize("name", CHECKSUMS)
def test_check_value(name: str) -> None:
    assert CHECKSUMS[name].of(b"123456789") == CHECK[name]
    assert CHECKSUMS[name].of(b"") < 1 << 8 * max(1, CHECKSUMS[name].size)
