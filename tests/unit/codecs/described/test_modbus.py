"""Declared registers and coils: what every polled codec must do, makers' bytes, and what is asked together."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.codecs import get_codec
from end_effector_hal.codecs.conformance import EXAMPLES
from end_effector_hal.codecs.described._codec import DescribedCodec
from end_effector_hal.codecs.polled_conformance import PolledCodecConformance
from end_effector_hal.signals import Frame, Kind, Value

from .declared import declared


def adu(text: str) -> bytes:
    return bytes.fromhex(text)


def crc(data: bytes) -> bytes:
    """CRC-16 of Modbus bit by bit, as the standard describes it; shares no code with the product."""
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ 0xA001 if value & 1 else value >> 1
    return struct.pack("<H", value)


EPICK = (
    "cup: {modbus: {unit: 9, address: 0x07D2, register_type: input, bitmask: 0xFF00}, "
    "unit: kPa, offset: -100, range: [-100, 0]}"
)
GRIPPED = "part: {modbus: {unit: 9, address: 0x07D0, register_type: input, bitmask: 0xC000}, on: [1, 2]}"
NOTHING = "nothing: {modbus: {unit: 9, address: 0x07D0, register_type: input, bitmask: 0xC000}, on: [3]}"


def epick_answer(*, object_: int, kpa_below: int) -> bytes:
    """The status of an EPick: object detection in bits 7 and 6 of the first byte, pressure in the fifth."""
    content = bytes([object_ << 6 | 0b11_0001, 0, 0, 0, 100 - kpa_below, 0])
    head = bytes([9, 4, len(content)]) + content
    return head + crc(head)


class TestEPick(PolledCodecConformance):
    codec = declared("{modbus: {}}", EPICK, GRIPPED, NOTHING, link="baudrate: 115200")
    # The request is that of Robotiq's manuals. Only declared bits are in what a simulated device answers.
    vectors = (
        (
            (
                (
                    adu("09 04 07D0 0003 B1CE"),
                    adu("09 04 06 4000 0000 1F00") + crc(adu("09 04 06 4000 0000 1F00")),
                ),
            ),
            Frame(5, None, None, {"part": True, "nothing": False, "cup": -69_000}),
        ),
    )

    def values(self, data: st.DataObject) -> dict[str, Value]:
        """One number says both bits."""
        side = data.draw(st.sampled_from(["", "part", "nothing"]), label="object")
        cup = data.draw(st.integers(-90_000, 0), label="cup")
        return {"part": side == "part", "nothing": side == "nothing", "cup": cup}


@EXAMPLES
@given(object_=st.integers(0, 3), kpa_below=st.integers(0, 99))
def test_an_epick_by_an_encoder_of_its_own(object_: int, kpa_below: int) -> None:
    decoder = TestEPick.codec.decoder()
    assert decoder.poll(0).data == adu("09 04 07D0 0003") + crc(adu("09 04 07D0 0003"))
    (frame,) = decoder.feed(epick_answer(object_=object_, kpa_below=kpa_below), 5)
    assert frame.values == {
        "part": object_ in (1, 2),
        "nothing": object_ == 3,
        "cup": -1000 * kpa_below,
    }


def gripper(table: str) -> DescribedCodec:
    status = f"modbus: {{unit: 9, register_type: {table}, address: 0x07D0, bitmask: "
    return declared(
        "{modbus: {}}",
        f"cup: {{{status}0xC000}}, on: [2]}}",
        f"open: {{{status}0xC000}}, on: [3]}}",
        f"ready: {{{status}0x3000}}, on: [3]}}",
        f"asked: {{modbus: {{unit: 9, register_type: {table}, address: 0x07D1, bitmask: 0x00FF}}, unit: Pa}}",
        f"position: {{modbus: {{unit: 9, register_type: {table}, address: 0x07D2, bitmask: 0xFF00}}, unit: Pa}}",
        link="baudrate: 115200",
    )


@pytest.mark.parametrize(
    ("table", "request_", "answer", "values"),
    [
        # 2-Finger 200 manual, page 60, and the 2F-85 manual: reading with function 3 while the gripper closes
        ("holding", "09 03 07D0 0003 040E", "09 03 06 3900 00FF 0E0A F78B", (False, False, True, 255, 14)),
        ("holding", "09 03 07D0 0003 040E", "09 03 06 B900 00FF BD00 1D7C", (True, False, True, 255, 189)),
        # 2F-85 & 2F-140 manual, page 80: with function 4, opened
        ("input", "09 04 07D0 0003 B1CE", "09 04 06 F900 0000 0D00 17AA", (False, True, True, 0, 13)),
    ],
)
def test_a_2f_85_by_the_examples_of_its_manuals(
    table: str, request_: str, answer: str, values: tuple[Value, ...]
) -> None:
    decoder = gripper(table).decoder()
    assert decoder.poll(0).data == adu(request_)
    (frame,) = decoder.feed(adu(answer), 5)
    assert frame.values == dict(zip(("cup", "open", "ready", "asked", "position"), values, strict=True))


class TestManyTypes(PolledCodecConformance):
    """Two units; coils, discrete inputs, both kinds of registers; 32 bits in both orders; signs and fractions."""

    codec = declared(
        "{modbus: {timeout_ms: 50}}",
        "cup: {modbus: {unit: 1, address: 0x10, value_type: int16}, unit: hPa, invalid: [-32768]}",
        "top: {modbus: {unit: 1, address: 0x11, value_type: int32}, unit: Pa, invalid: [2147483647]}",
        "far: {modbus: {unit: 1, address: 0x15, value_type: float32, word_order: little}, unit: kPa}",
        "low: {modbus: {unit: 2, address: 0x10, register_type: input, value_type: uint32}, unit: Pa,"
        " scale: -1, range: [-100000, 0]}",
        "coil: {modbus: {unit: 2, address: 7, register_type: coil}, invert: true}",
        "switch: {modbus: {unit: 2, address: 1, register_type: discrete_input}}",
        "next_one: {modbus: {unit: 2, address: 4, register_type: discrete_input}}",
    )
    vectors = (
        (
            (
                (adu("01 03 0010 0007 05CD"), adu("01 03 0E FCF2 FFFE CE56 0000 0000 8000 C29C FF07")),
                (adu("02 01 0007 0001 4C38"), adu("02 01 01 00 51CC")),
                (adu("02 02 0001 0004 283A"), adu("02 02 01 09 61CA")),
                (adu("02 04 0010 0002 703D"), adu("02 04 04 0000 7530 EE00")),
            ),
            Frame(
                5,
                None,
                None,
                {
                    "cup": -78_200,
                    "top": -78_250,
                    "far": -78_250,
                    "low": -30_000,
                    "coil": True,
                    "switch": True,
                    "next_one": True,
                },
            ),
        ),
    )

    def test_no_value_is_no_value(self) -> None:
        """A coil has no way to say so: its unit refuses, and the others stay what they are."""
        (frame,) = self.cycle(self.codec.decoder(), dict.fromkeys(self.codec.channels))
        assert frame.values == dict.fromkeys(self.codec.channels)
        decoder = self.codec.decoder()
        values: dict[str, Value] = dict.fromkeys(self.codec.channels, 0) | {"coil": False, "cup": None}
        (frame,) = self.cycle(decoder, values)
        assert {name for name, value in frame.values.items() if value is None} == {"cup"}


@EXAMPLES
@given(
    st.integers(-(2**31), 2**31 - 1),
    st.floats(width=32),
    st.integers(0, 0xFFFF),
    st.booleans(),
    st.booleans(),
)
def test_types_by_an_encoder_of_its_own(
    wide: int, fraction: float, word: int, first: bool, last: bool
) -> None:
    content = struct.pack(">hi", -1, wide) + bytes(4)
    content += struct.pack(">f", fraction)[2:] + struct.pack(">f", fraction)[:2]
    bodies = (
        bytes([1, 3, 14]) + content,
        bytes([2, 1, 1, 0xFE | first]),
        bytes([2, 2, 1, 0xF0 | first | last << 3]),
        bytes([2, 4, 4]) + struct.pack(">I", word),
    )
    decoder, frames = TestManyTypes.codec.decoder(), []
    for body in bodies:
        assert decoder.poll(decoder.due).data[:2] == body[:2]
        frames += decoder.feed(body + crc(body), 5)
    values = frames[0].values
    assert values["cup"] == -100
    assert values["top"] == (None if wide in (2**31 - 1, -(2**31)) else wide)
    # neither NaN, nor more than any pressure, nor less than a sensor can mean
    known = abs(fraction * 1000) < 2**31 - 1 and not 0 < abs(fraction) < 1e-9
    assert values["far"] == (pytest.approx(fraction * 1000, abs=0.51) if known else None)
    assert values["low"] == -word
    assert (values["coil"], values["switch"], values["next_one"]) == (not first, first, last)


def asked(*channels: str, frame: str = "{modbus: {}}") -> list[tuple[int, int, int, int]]:
    codec = declared(frame, *channels)
    return [(read.unit, read.function, read.address, read.count) for read in codec.reads]  # type: ignore[attr-defined]


def at(name: str, address: int, **keys: object) -> str:
    more = "".join(f", {key}: {value}" for key, value in keys.items())
    return f"{name}: {{modbus: {{address: {address}{more}}}, unit: Pa}}"


def test_neighbours_are_read_with_one_request_and_others_are_not() -> None:
    near = (at("cup", 10), at("b", 11), at("c", 20, value_type="int32"))
    assert asked(*near) == [(1, 3, 10, 12)]
    assert asked(*near, frame="{modbus: {gap: 7}}") == [(1, 3, 10, 2), (1, 3, 20, 3)]
    assert asked(at("cup", 1), at("b", 1, unit=2), at("c", 1, register_type="input")) == [
        (1, 3, 1, 1),
        (1, 4, 1, 1),
        (2, 3, 1, 1),
    ]
    assert asked(*(at(name, 8 * index) for index, name in enumerate(["cup", *"bcdefghijklmnop"]))) == [
        (1, 3, 0, 97),
        (1, 3, 104, 17),
    ]


def test_no_two_answers_of_one_unit_can_be_taken_for_each_other() -> None:
    """A late answer to the first would be a value of the second: one more register is read with it."""
    assert asked(at("cup", 10), at("b", 100), at("c", 200)) == [(1, 3, 10, 1), (1, 3, 100, 2), (1, 3, 200, 3)]
    assert asked(at("cup", 10), at("b", 65535)) == [(1, 3, 10, 1), (1, 3, 65534, 2)]
    bits = [f"{name}: {{modbus: {{address: {n}, register_type: coil}}}}" for name, n in (("b", 0), ("c", 99))]
    assert asked(at("cup", 10), *bits) == [(1, 1, 0, 1), (1, 1, 99, 9), (1, 3, 10, 1)]
    codec = declared("{modbus: {}}", at("cup", 10), at("b", 65535))
    (frame,) = PolledCodecConformance().cycle.__func__(  # type: ignore[attr-defined]
        type("Both", (), {"codec": codec}), codec.decoder(), {"cup": 1, "b": 2}
    )
    assert frame.values == {"cup": 1, "b": 2}


def test_no_register_is_read_that_nobody_declared_beyond_the_gap() -> None:
    """A device may refuse a read that has a register which it does not have."""
    tight = declared("{modbus: {gap: 0}}", at("cup", 10), at("b", 100))
    assert [(each.address, each.count) for each in tight.reads] == [(10, 1), (100, 1)]  # type: ignore[attr-defined]
    one = asked(at("cup", 10), at("b", 100), at("c", 200), frame="{modbus: {gap: 1}}")
    assert one == [(1, 3, 10, 1), (1, 3, 100, 2), (1, 3, 200, 1)]


def test_where_answers_are_alike_a_late_one_is_never_taken_for_another() -> None:
    codec = declared("{modbus: {gap: 0}}", at("cup", 10), at("b", 100))
    decoder, device = codec.decoder(), codec.device()  # type: ignore[attr-defined]
    values = {"cup": 5, "b": 6}
    late = device.answer(decoder.poll(0).data, values)
    frames, sent, now = [], [], 0
    while now < 1_200_000:
        now = decoder.due
        polled = decoder.poll(now)
        frames += polled.frames
        if polled.data:
            sent.append((now, polled.data[3]))
            # that to the first, which was asked again; the other one never answers
            frames += decoder.feed(late, now + 1) if polled.data[3] == 10 else []
    assert sent[0][1] == 10
    assert {each.values["b"] for each in frames} == {None}
    assert {each.values["cup"] for each in frames} == {5}
    first = next(asked_at for asked_at, address in sent if address == 100)
    assert 1_000_000 < first < 1_150_000


def test_one_unit_that_does_not_answer_costs_only_its_own_channels() -> None:
    codec = declared("{modbus: {}}", at("cup", 1), at("b", 1, unit=2))
    decoder, device, frames = codec.decoder(), codec.device(), []  # type: ignore[attr-defined]
    while not frames:
        polled = decoder.poll(decoder.due)
        frames += polled.frames
        if polled.data and polled.data[0] == 1:
            frames += decoder.feed(device.answer(polled.data, {"cup": 5, "b": 6}), decoder.due - 1)
    assert frames[0].values == {"cup": 5, "b": None}


def test_what_the_bus_is_by_default_and_how_long_a_cycle_takes() -> None:
    one, two = (declared("{modbus: {}}", at("cup", 1), *more) for more in ((), (at("b", 1, unit=2),)))
    assert (one.baudrate, one.parity) == (9_600, "N")
    # 8 bytes asked, 7 answered, each of 11 bits; twice 3.5 bytes of silence
    assert one.least_period_us == 15 * 11 * 1_000_000 // 9600 + 2 * (38 * 1_000_000 // 9600)
    assert two.least_period_us == 2 * one.least_period_us
    assert two.period_us == two.least_period_us + 10_000
    fast = declared("{modbus: {}}", at("cup", 1), link="baudrate: 115200\nperiod_ms: 50")
    assert fast.period_us == 50_000


PRESETS = {
    "modbus-rtu-epick": (
        "baudrate: 115200\nperiod_ms: 20",
        [
            "vacuum: {modbus: {unit: 9, address: 2002, register_type: input, bitmask: 0xFF00}, unit: kPa, offset: -100}"
        ],
    ),
    "modbus-rtu-onrobot-vg": (
        "baudrate: 115200\nparity: E\nperiod_ms: 50",
        [
            f"{name}: {{modbus: {{unit: 65, address: {address}}}, unit: Pa, scale: -101.325, range: [-101325, 0]}}"
            for name, address in (("vacuum_a", 18), ("vacuum_b", 19))
        ],
    ),
    "modbus-rtu-transmitters": (
        "period_ms: 200",
        [
            f"{name}: {{modbus: {{unit: {unit}, address: 0x16, value_type: int16}}, unit: hPa, range: [-1100, 20000]}}"
            for unit, name in enumerate(("bottom", "cylinder", "top", "supply"), start=1)
        ],
    ),
}


@pytest.mark.parametrize("name", PRESETS)
@EXAMPLES
@given(data=st.data())
def test_each_shipped_codec_of_modbus_can_be_declared(name: str, data: st.DataObject) -> None:
    """The same channels, rates and values from the same answers; it may read fewer registers."""
    link, channels = PRESETS[name]
    shipped, own = get_codec(name), declared("{modbus: {}}", *channels, link=link)
    assert own.channels == shipped.channels
    assert (own.baudrate, own.parity, own.period_us) == (shipped.baudrate, shipped.parity, shipped.period_us)
    assert own.resolution_pa == pytest.approx(shipped.resolution_pa)  # type: ignore[attr-defined]
    values: dict[str, Value] = {each: data.draw(st.integers(-90_000, 0)) for each in own.channels}
    mine, theirs = (
        PolledCodecConformance.cycle(type("Any", (), {"codec": codec}), codec.decoder(), values)  # type: ignore[arg-type]
        for codec in (own, shipped)
    )
    assert mine[0].values == theirs[0].values
    assert set(own.channels.values()) == {Kind.PRESSURE}


def test_the_bytes_of_a_register_may_come_the_other_way_round() -> None:
    codec = declared(
        "{modbus: {}}",
        "cup: {modbus: {address: 0, value_type: int16, byte_order: little}, unit: Pa}",
        "top: {modbus: {address: 1, value_type: int32, byte_order: little}, unit: Pa}",
        "far: {modbus: {address: 3, value_type: int32, byte_order: little, word_order: little}, unit: Pa}",
        "bit: {modbus: {address: 5, byte_order: little, bitmask: 0x0001}}",
    )
    values = {"cup": 0x1234, "top": 0x01020304, "far": 0x01020304, "bit": True}
    data = "34 12 02 01 04 03 04 03 02 01 01 00"
    answer = codec.encode(Frame(0, None, None, values))
    assert answer[3:-2] == bytes.fromhex(data)
    decoder = codec.decoder()
    decoder.poll(0)
    (frame,) = decoder.feed(answer, 5)
    assert frame.values == values
