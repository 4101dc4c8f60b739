import tomllib
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.codecs import Ees1Ascii, Ees1Cobs, LegacyNibble, _registry, get_codec
from end_effector_hal.codecs.conformance import CodecConformance
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Frame, Kind

BITS = (
    "locked",
    "unlocked",
    "tool_present",
    "in_stand",
    "cylinder_extended",
    "cylinder_retracted",
    "estop_ok",
)


def ees1(seq, ms, pressures, *on):
    values = dict(zip(("bottom", "cylinder", "top", "supply"), pressures, strict=True))
    return Frame(0, seq, ms, values | {bit: bit in on for bit in BITS})


FIRST = b"$EES1,0,0,0,0,0,600000,00,00*B19D\r\n"
SECOND = b"$EES1,41,820,-78250,598000,-76100,601000,0E,00*645A\r\n"
THIRD = b"$EES1,65535,4294967295,-78250,,-76100,601000,0E,02*323D\r\n"
VECTORS = (
    (FIRST, ees1(0, 0, (0, 0, 0, 600_000))),
    (SECOND, ees1(41, 820, (-78_250, 598_000, -76_100, 601_000), "unlocked", "tool_present", "in_stand")),
    (
        THIRD,
        ees1(
            65_535, 4_294_967_295, (-78_250, None, -76_100, 601_000), "unlocked", "tool_present", "in_stand"
        ),
    ),
)


class TestEes1Ascii(CodecConformance):
    codec = Ees1Ascii()
    vectors = VECTORS


class TestEes1Cobs(CodecConformance):
    codec = Ees1Cobs()
    vectors = ((bytes.fromhex("0004010129033403010ac6f3705d1cf4e85d0e0356c600"), VECTORS[1][1]),)


class TestLegacyNibble(CodecConformance):
    codec = LegacyNibble()
    has_checksum = False
    vectors = (
        (
            b"\x0e",
            Frame(
                0,
                None,
                None,
                {"unlocked": True, "bottom": True, "cylinder_extended": True, "top": False, "locked": False},
            ),
        ),
        (
            b"\x01",
            Frame(
                0,
                None,
                None,
                {"unlocked": False, "bottom": False, "cylinder_extended": False, "top": True, "locked": True},
            ),
        ),
    )


def line(seq, ms=None):
    return Ees1Ascii().encode(ees1(seq, 20 * seq if ms is None else ms, (0, 0, 0, 0)))


def fed(*chunks):
    decoder = Ees1Ascii().decoder()
    return decoder, [frame for chunk in chunks for frame in decoder.feed(chunk, 5)]


def test_every_single_bit_error_is_detected():
    for i in range(8 * len(SECOND)):
        bad = bytearray(SECOND)
        bad[i // 8] ^= 1 << i % 8
        _, frames = fed(bytes(bad))
        # The CRC's own hex digits may change case and still say the same.
        assert all(bytes(bad).upper() == SECOND and frame.seq == 41 for frame in frames)


@given(st.binary(max_size=200), st.integers(0, len(SECOND)))
def test_noise_inside_costs_only_its_own_frame(noise, cut):
    _, frames = fed(line(1), SECOND[:cut] + noise.replace(b"$", b""), line(2))
    assert [frame.seq for frame in frames if frame.seq != 41] == [1, 2]


def test_wrong_crc_is_counted():
    decoder, frames = fed(SECOND.replace(b"645A", b"645B"))
    assert (frames, decoder.errors["crc"]) == ([], 1)


def test_missing_carriage_return_is_no_frame():
    decoder, frames = fed(SECOND.replace(b"\r", b""))
    assert (frames, decoder.errors["format"]) == ([], 1)


def test_repeated_number_is_dropped():
    decoder, frames = fed(line(3, 60), line(3, 80), line(4, 80))
    assert [frame.seq for frame in frames] == [3, 4]
    assert (decoder.errors["duplicate"], decoder.lost, decoder.reboots) == (1, 0, 0)


def test_gap_is_lost():
    decoder, frames = fed(line(3), line(7))
    assert [frame.seq for frame in frames] == [3, 7]
    assert (decoder.lost, decoder.reboots) == (3, 0)


def test_wrap_around_is_no_gap():
    decoder, frames = fed(line(65_535, (1 << 32) - 10), line(0, 10))
    assert len(frames) == 2
    assert (decoder.lost, decoder.reboots) == (0, 0)


@pytest.mark.parametrize(
    ("last", "first"), [((100, 2000), (0, 0)), ((40_000, 800_000), (0, 0)), ((0, 20), (0, 0))]
)
def test_jump_back_is_a_reboot(last, first):
    decoder, frames = fed(line(*last), line(*first))
    assert len(frames) == 2
    assert (decoder.lost, decoder.reboots) == (0, 1)


def body(text):
    from binascii import crc_hqx

    return b"$%s*%04X\r\n" % (text, crc_hqx(text, 0xFFFF))


@pytest.mark.parametrize("text", [b"EES1,65536,0,0,0,0,0,00,00", b"EES1,0,4294967296,0,0,0,0,00,00"])
def test_counter_out_of_range_is_no_frame(text):
    decoder, frames = fed(body(text))
    assert (frames, decoder.errors["range"]) == ([], 1)


@pytest.mark.parametrize("pressure", [b"-110001", b"2000001"])
def test_pressure_out_of_range_is_invalid(pressure):
    decoder, frames = fed(body(b"EES1,0,0,%s,1,2,3,00,00" % pressure))
    assert [frame.values["bottom"] for frame in frames] == [None]
    assert frames[0].values["cylinder"] == 1
    assert decoder.errors["range"] == 1


def test_status_bit_makes_a_given_value_invalid():
    _, (frame,) = fed(body(b"EES1,0,0,1,2,3,4,00,0A"))
    assert [frame.values[name] for name in ("bottom", "cylinder", "top", "supply")] == [1, None, 3, None]


def test_time_is_that_of_the_last_byte():
    decoder = Ees1Ascii().decoder()
    assert decoder.feed(SECOND[:-1], 10) == []
    assert [frame.at for frame in decoder.feed(SECOND[-1:], 20)] == [20]


@pytest.mark.parametrize("value", [-110_001, 2_000_001])
def test_encode_refuses_what_does_not_fit(value):
    with pytest.raises(UsageError, match="bottom"):
        Ees1Ascii().encode(ees1(0, 0, (value, 0, 0, 0)))


def test_nibble_refuses_a_high_nibble():
    decoder = LegacyNibble().decoder()
    assert len(decoder.feed(b"\x1e\x0e\xff", 0)) == 1
    assert decoder.errors["format"] == 2
    assert set(LegacyNibble().channels.values()) == {Kind.BIT}


def test_unknown_codec():
    with pytest.raises(UsageError, match="Did you mean ees1-ascii"):
        get_codec("ees1-asci")
    with pytest.raises(
        UsageError, match="There are: ees1-ascii, ees1-cobs, legacy-nibble, modbus-rtu-epick, "
    ):
        get_codec("x")


def test_entry_point(monkeypatch):
    points = EntryPoints(
        [
            EntryPoint("mine", "end_effector_hal.codecs:LegacyNibble", _registry.GROUP),
            EntryPoint("broken", "no_such_module:X", _registry.GROUP),
            EntryPoint("half", "end_effector_hal.codecs:Half", _registry.GROUP),
        ]
    )
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **kw: points.select(**kw))
    assert get_codec("mine").channels == LegacyNibble.channels
    assert _registry.codec_names() == (*_registry.OWN, "broken", "half", "mine")
    with pytest.raises(UsageError, match="cannot be loaded"):
        get_codec("broken")
    monkeypatch.setattr("end_effector_hal.codecs.Half", object(), raising=False)
    with pytest.raises(
        UsageError, match="half: this is not a codec: it has no name, channels, period_us, baudrate"
    ):
        get_codec("half")


def test_our_own_are_the_entry_points_of_this_distribution():
    project = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["entry-points"][_registry.GROUP] == _registry.OWN
    for name in _registry.OWN:
        assert get_codec(name).name == name


def cobs(seq, ms=None, pressures=(0, 0, 0, 0)):
    return Ees1Cobs().encode(ees1(seq, 20 * seq if ms is None else ms, pressures))


def test_cobs_every_single_bit_error_is_detected():
    frame = cobs(41, 820, (-78_250, 598_000, -76_100, 601_000))
    for i in range(8 * len(frame)):
        bad = bytearray(frame)
        bad[i // 8] ^= 1 << i % 8
        # the zeros around it may change: what is between them is whole
        assert [each.seq for each in Ees1Cobs().decoder().feed(bytes(bad) + b"\0", 0)] in ([], [41])
        if 8 <= i < 8 * len(frame) - 8:
            assert Ees1Cobs().decoder().feed(bytes(bad), 0) == []


def test_cobs_rounds_to_25_pa_and_says_what_is_invalid():
    (frame,) = Ees1Cobs().decoder().feed(cobs(1, pressures=(-78_262, None, 12, 819_175)), 0)
    assert [frame.values[name] for name in ("bottom", "cylinder", "top", "supply")] == [
        -78_250,
        None,
        0,
        819_175,
    ]


@pytest.mark.parametrize("value", [-110_001, 819_176])
def test_cobs_refuses_what_does_not_fit(value):
    with pytest.raises(UsageError, match="bottom"):
        cobs(1, pressures=(value, 0, 0, 0))


def test_cobs_of_another_version_is_no_frame():
    from binascii import crc_hqx

    from cobs.cobs import decode, encode

    good = decode(cobs(1)[1:-1])
    other = b"\2" + good[1:-2]
    decoder = Ees1Cobs().decoder()
    assert decoder.feed(b"\0" + encode(other + crc_hqx(other, 0xFFFF).to_bytes(2, "little")) + b"\0", 0) == []
    assert decoder.errors["format"] == 1


def test_cobs_is_less_than_half_of_the_bytes():
    assert (len(cobs(41)), len(SECOND)) == (23, 53)
