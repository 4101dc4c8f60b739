"""Channels under names chosen by the user: the meaning of each signal, and its source.

The keys are those that users of ESPHome, Home Assistant and Telegraf know: ``address``, ``register_type``,
``value_type``, ``byte_order``, ``bitmask``, ``scale``, ``offset``.
"""

from __future__ import annotations

import re
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

from pydantic import BeforeValidator, Field, PlainValidator, model_validator
from pydantic_core import PydanticKnownError

from end_effector_hal.kinds.stanza import BaseStanza, LineName, Name, Names, Word, stanza_fault
from end_effector_hal.signals import Kind, Value
from end_effector_hal.vocabulary import MOST_CHANNELS

Unit = Literal[
    "Pa", "hPa", "kPa", "MPa", "mbar", "bar", "psi", "inHg", "Torr", "mmHg",
    "mm", "deg", "%", "V", "mA", "A", "N", "g", "kg", "degC",
]  # fmt: skip
PASCAL: dict[str, float] = {
    "Pa": 1.0,
    "hPa": 100.0,
    "kPa": 1_000.0,
    "MPa": 1_000_000.0,
    "mbar": 100.0,
    "bar": 100_000.0,
    "psi": 6_894.757,
    "inHg": 3_386.389,
    "Torr": 133.3224,
    "mmHg": 133.3224,
}
"""Pa per unit of pressure."""

QUANTITIES: tuple[str, ...] = tuple(unit for unit in get_args(Unit) if unit not in PASCAL)
"""Units of quantities other than pressure; their values are counted in thousandths."""
COUNTS: dict[str, float] = PASCAL | dict.fromkeys(QUANTITIES, 1_000.0)
"""Counts of a frame's value per unit: Pa for a pressure, thousandths for any other unit."""

HIGHEST_PA = 2**31 - 1
TINY = 1e-9
"""Smallest value other than 0 that a sensor can mean, in units of a raw number with a fraction.

A smaller one is invalid: the words are in the wrong order.
"""

NUMBER = re.compile(r"[+-]?([0-9]{1,20}(\.[0-9]{0,20})?|\.[0-9]{1,20})([eE][+-]?[0-9]{1,2})?")
"""A number in a text."""
ValueType = Literal["uint8", "int8", "uint16", "int16", "uint32", "int32", "float32"]
ByteOrder = Literal["big", "little"]
Factor = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]
Raw = Annotated[int, Field(ge=-(2**31), le=2**32 - 1)]
Raws = Annotated[tuple[Raw, ...], Field(strict=False, max_length=64)]
_WORD_LENGTH, _OPPOSITES = (
    40,
    (("on", "off"), ("true", "false"), ("yes", "no"), ("high", "low"), ("open", "closed")),
)
OPPOSITE: dict[str, str] = {
    cased(one): cased(other)
    for pair in _OPPOSITES
    for one, other in (pair, pair[::-1])
    for cased in (str.lower, str.upper, str.capitalize)
}
"""Words that mean off if these mean on, and the reverse, in the same case."""


def _raw_or_word(given: Any) -> int | str:
    """Return a raw value that means on or off; true and false are the words of JSON."""
    if isinstance(given, bool):
        return str(given).lower()
    if isinstance(given, str):
        if not 0 < len(given) <= _WORD_LENGTH or given != given.strip() or not given.isprintable():
            expected = f"1 to {_WORD_LENGTH} printed characters without blanks around them"
            raise stanza_fault("EE-211", "this word is never received", expected)
        if NUMBER.fullmatch(given):
            raise stanza_fault("EE-207", "this is a number", "the number without quotes", f"write {given}")
        return given
    if not isinstance(given, int):
        raise PydanticKnownError("int_type")
    if given < -(2**31):
        raise PydanticKnownError("greater_than_equal", {"ge": -(2**31)})
    if given > 2**32 - 1:
        raise PydanticKnownError("less_than_equal", {"le": 2**32 - 1})
    return given


RawOrWord = Annotated[int | str, PlainValidator(_raw_or_word, json_schema_input_type=Raw | str | bool)]
RawsOrWords = Annotated[tuple[RawOrWord, ...], Field(strict=False, max_length=64)]
Span = Annotated[tuple[Factor, Factor], Field(strict=False)]
Bitmask = Annotated[int | None, Field(ge=1, le=2**32 - 1)]
Bytes = Annotated[int, Field(ge=0, le=255)]
HEXADECIMAL = r"^([0-9A-Fa-f]{2}){1,8}$"
Hexadecimal = Annotated[str, Field(pattern=HEXADECIMAL)]


def type_bits(value_type: str) -> int:
    """Return the width of a value type on the wire, bits."""
    return int(value_type.lstrip("uintfloa"))


def raw_limits(value_type: str, bitmask: int | None = None) -> tuple[int, int] | None:
    """Return the lowest and the highest raw value of a type, or of its masked bits; None for float32."""
    if value_type == "float32":
        return None
    bits = type_bits(value_type) if bitmask is None else mask_width(bitmask)
    half = 1 << (bits - 1)
    return (0, 2 * half - 1) if value_type.startswith("u") else (-half, half - 1)


def mask_width(bitmask: int) -> int:
    """Return the number of bits of a masked value after it is shifted down to bit 0."""
    return (bitmask >> mask_shift(bitmask)).bit_length()


def mask_shift(bitmask: int) -> int:
    """Return the number of bits by which a masked value is shifted down."""
    return (bitmask & -bitmask).bit_length() - 1


class TextValue(BaseStanza):
    """A value in a line of text, found by its position among the fields or by its key."""

    field: Annotated[int | None, Field(ge=1, le=MOST_CHANNELS)] = Field(
        default=None, description="which of the separated fields, from 1 on"
    )
    key: Annotated[str | None, Field(min_length=1, max_length=40)] = Field(
        default=None, description="key in front of the value, such as P1 in P1=-52.3"
    )
    decimals: Annotated[int | None, Field(ge=0, le=9)] = Field(
        default=None,
        description="digits after the point that the device sends; a coarse value is never called frozen",
    )


class JsonValue(BaseStanza):
    """A value in a line of JSON."""

    key: Annotated[str, Field(min_length=1, max_length=80)] = Field(
        description="its path: keys and places in lists, from 0 on, with points between them: sensors.0.pressure"
    )
    decimals: Annotated[int | None, Field(ge=0, le=9)] = Field(
        default=None,
        description="digits after the point that the device sends; a coarse value is never called frozen",
    )


class RecordValue(BaseStanza):
    """A value in a binary record."""

    byte: Bytes = Field(description="its first byte, counted from 0 at the first byte after the start bytes")
    value_type: ValueType = Field(default="uint8", description="how its bytes are read")
    byte_order: ByteOrder = Field(default="big", description="which byte comes first")
    bitmask: Bitmask = Field(default=None, description="these bits of it, moved down to bit 0; default: all")


class RegisterValue(BaseStanza):
    """A value in a register, or a coil, of a Modbus device."""

    unit: Annotated[int, Field(ge=0, le=255)] = Field(
        default=1, description="address of the device on the bus"
    )
    address: Annotated[int, Field(ge=0, le=0xFFFF)] = Field(
        description="as it stands on the wire, from 0 on (40001 in a manual is 0)"
    )
    register_type: Literal["holding", "input", "coil", "discrete_input"] = Field(
        default="holding", description="which table of the device; function 3, 4, 1 or 2"
    )
    value_type: Literal["uint16", "int16", "uint32", "int32", "float32"] = Field(
        default="uint16", description="how its registers are read; 32 bits take two"
    )
    byte_order: ByteOrder = Field(
        default="big", description="which byte of a register comes first; little: against the standard"
    )
    word_order: ByteOrder = Field(default="big", description="of 32 bits: which register comes first")
    bitmask: Bitmask = Field(default=None, description="these bits of it, moved down to bit 0; default: all")


class DigitalInput(BaseStanza):
    """An input line of the board."""

    line: LineName = Field(description="name of the GPIO line, as gpioinfo shows it")
    bias: Literal["as_is", "pull_up", "pull_down", "disabled"] = Field(
        default="as_is", description="resistor of the chip; NPN sensors pull low and take pull_up"
    )
    debounce_ms: Annotated[int, Field(ge=0, le=1000)] = Field(
        default=0, description="the kernel reports a level that lasts for this long; 0: each edge"
    )
    poll_ms: Annotated[int | None, Field(ge=1, le=1000)] = Field(
        default=None,
        description="of a chip that reports no edges: its level is read this often, without debounce_ms",
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if self.poll_ms and self.debounce_ms:
            what = "poll_ms and debounce_ms exclude each other"
            raise stanza_fault("EE-222", what, "poll_ms only: a level that is shorter is mostly not seen")
        return self


class AnalogInput(BaseStanza):
    """An analog input through Linux IIO, read from sysfs: ``in_<channel>_raw`` of a device."""

    device: Annotated[str, Field(pattern=r"^[A-Za-z0-9_.,:@-]{1,64}$")] = Field(
        description="what its file `name` or `label` says, such as ads1015; or iio:device0"
    )
    channel: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_-]{0,39}$")] = Field(
        description="of the device, such as voltage0 or pressure"
    )


def part_of(stanza: BaseStanza, key: str) -> Any:
    """Return the value of a key; the field of `json` has another name, because pydantic has a method of that name."""
    return getattr(stanza, "json_" if key == "json" else key)


class CodecValue(BaseStanza):
    """A channel of the codec that a link names; the codec defines its meaning."""

    channel: Name = Field(description="its name in the codec; docs/reference/codecs.md lists them")


class DeviceAlarm(BaseStanza):
    """A fault that a device reports while a bit is on, or while a channel has a code."""

    text: Annotated[Word, Field(min_length=1, max_length=200)] = Field(
        description="what an operator reads: what has happened, and what to do"
    )
    code: Annotated[int | None, Field(ge=-(2**31), le=2**31 - 1)] = Field(
        default=None,
        description="raw value that means this; null: the bit is on, or any code that has no text",
    )
    severity: Literal["error", "warning"] = Field(
        default="error",
        description="error: no new grip begins while it stands or is latched (IL-07); warning: it is reported, no more",
    )
    latches: bool = Field(
        default=True, description="it stays until a reset, even if the device no longer reports it"
    )
    unproven: Names = Field(
        default=(),
        description="actuators whose sensors prove nothing while it stands, or while the channel has no reading",
    )


def _listed(given: Any) -> Any:
    """Return a single text or a single alarm as a list."""
    given = {"text": given} if isinstance(given, str) else given
    return [given] if isinstance(given, dict) else given


DeviceAlarms = Annotated[
    tuple[DeviceAlarm, ...],
    Field(strict=False, max_length=64),
    BeforeValidator(_listed, json_schema_input_type=str | DeviceAlarm | tuple[DeviceAlarm, ...]),
]


class Channel(BaseStanza):
    """One signal: its source (one of text, json, record, modbus, codec, digital, analog) and its meaning."""

    link: Name | None = Field(
        default=None, description="name under `links` of its link, if there are several"
    )
    text: TextValue | None = Field(default=None, description="in a line of text that comes over the link")
    json_: JsonValue | None = Field(
        default=None, alias="json", description="in a line of JSON that comes over the link"
    )
    record: RecordValue | None = Field(
        default=None, description="in a binary record that comes over the link"
    )
    modbus: RegisterValue | None = Field(default=None, description="in a Modbus device on the link")
    codec: CodecValue | None = Field(
        default=None, description="a channel of the link's codec, under a name of your own"
    )
    digital: DigitalInput | None = Field(default=None, description="an input line of the board")
    analog: AnalogInput | None = Field(default=None, description="an analog input of the board (Linux IIO)")
    device: Word | None = Field(
        default=None,
        exclude=True,
        description="a device of the library, and beside it `input`, one of its inputs; its address on the bus is "
        "`modbus: {unit: …}`",
    )
    unit: Unit | None = Field(
        default=None,
        description="of raw * scale + offset: a gauge pressure (vacuum negative), or another quantity; absent: a bit",
    )
    scale: Factor = Field(
        default=1.0, description="units per count; of an analog input, per its own unit (mV)"
    )
    offset: Factor = Field(default=0.0, description="unit: added to raw * scale")
    range: Span | None = Field(
        default=None, description="unit: [lowest, highest] possible value; a value beyond is invalid"
    )
    invalid: Raws = Field(default=(), description="raw values that mean: there is no valid value")
    on: RawsOrWords | None = Field(
        default=None,
        description="of a bit: raw values that are on, of text and JSON also words; default: all but 0",
    )
    off: RawsOrWords | None = Field(
        default=None,
        description="of a bit: raw values that are off; any other is invalid then. Default: all but those of `on`; of "
        "words only their opposite, such as OFF of ON",
    )
    invert: bool = Field(default=False, description="of a bit: on is off (active low, normally closed)")
    alarm: DeviceAlarms = Field(
        default=(),
        description="a fault that the device reports: a text for a bit that is on, or a list with a text for each code",
    )

    OVER_LINK: ClassVar = ("text", "json", "record", "modbus", "codec")
    SOURCES: ClassVar = (*OVER_LINK, "digital", "analog")

    @property
    def source(self) -> str:
        """Source of the channel, one of `SOURCES`: the first that is written; empty if none is."""
        return next((name for name in self.SOURCES if part_of(self, name) is not None), "")

    @property
    def words(self) -> tuple[str, ...]:
        """Words that are on or off."""
        return tuple([each for each in (*(self.on or ()), *self.offs) if isinstance(each, str)])

    @property
    def offs(self) -> tuple[int | str, ...]:
        """Raw values that are off where all others are invalid; empty: all that are not on are off."""
        on = self.on or ()
        if self.off is not None or not any(isinstance(each, str) for each in on):
            return self.off or ()
        zero = any(not isinstance(each, str) for each in on) and 0 not in on
        return (*(OPPOSITE[each] for each in on if each in OPPOSITE), *((0,) if zero else ()))

    @property
    def on_board(self) -> bool:
        """Whether the channel is an input of the board; else it comes over the link."""
        return self.source not in ("", *self.OVER_LINK)

    @property
    def kind(self) -> Kind:
        """Type of the channel's values; for the source `codec` the codec defines it instead."""
        if any(each.code is not None for each in self.alarm):
            return Kind.CODE
        if self.unit is None:
            return Kind.BIT
        return Kind.PRESSURE if self.unit in PASCAL else Kind.QUANTITY

    def alarm_of(self, value: Value) -> DeviceAlarm | None:
        """Return the alarm that a value means; None: no fault, or no alarm is declared for it."""
        if not value:
            return None
        own = (each for each in self.alarm if each.code is not None and each.code == value)
        return next(own, next((each for each in self.alarm if each.code is None), None))

    @property
    def step_pa(self) -> float:
        """Smallest step of a value as far as known, Pa or thousandths; 1 for a float, which has none."""
        step = abs(self.scale) * COUNTS[self.unit or "Pa"]
        if line := self.text or self.json_:
            return step * 10.0 ** -(line.decimals or 0)
        place = self.record or self.modbus
        return 1.0 if place is not None and place.value_type == "float32" else step

    def value(self, raw: float | str) -> Value:
        """Return the meaning of a raw value or word: Pa, thousandths, a bit or a code; None: it is invalid."""
        if self.kind is Kind.BIT and (offs := self.offs):
            on = raw in (self.on or ())
            return on is not self.invert if (on or raw in offs) and raw not in self.invalid else None
        if (
            isinstance(raw, str)
            or raw != raw
            or raw in self.invalid
            or (0 < abs(raw) < 1 and abs(raw * self.scale) < TINY)
        ):
            return None
        if self.kind is Kind.CODE:
            code = int(raw) if abs(raw) <= HIGHEST_PA and raw == int(raw) else None
            return code if code is None or self.on is None or code in self.on else 0
        if self.unit is None:
            return (raw != 0 if self.on is None else raw in self.on) is not self.invert
        scaled = raw * self.scale + self.offset
        if self.range is not None and not self.range[0] <= scaled <= self.range[1]:
            return None
        counts = scaled * COUNTS[self.unit]
        return round(counts) if abs(counts) <= HIGHEST_PA else None

    def word(self, value: Value) -> str:
        """Return the word with this meaning; empty: it is said with a number."""
        among = (self.on or ()) if bool(value) is not self.invert else self.offs
        return next((each for each in among if isinstance(each, str)), "") if self.unit is None else ""

    def raw(self, value: int | bool) -> float:
        """Return a raw value with this meaning, for a simulated sensor to send.

        ``value`` is in Pa or thousandths, or a bit or code.
        """
        if self.kind is Kind.CODE:
            return float(value)
        if self.unit is None:
            on = bool(value) is not self.invert
            if self.on is None:
                return float(on)
            others = {*self.on, *self.invalid}
            numbers = [each for each in (self.on if on else self.offs) if not isinstance(each, str)]
            return float(
                numbers[0] if numbers else next(n for n in range(len(others) + 1) if n not in others)
            )
        raw = (value / COUNTS[self.unit] - self.offset) / self.scale
        return raw if abs(raw * self.scale) >= TINY else 0.0


Ask = Annotated[
    str | None,
    Field(
        min_length=1,
        max_length=64,
        description="request that the HAL sends every period_ms of the link, with the end of its line; the device "
        "answers with a line. null: it sends by itself",
    ),
]


class TextFrame(BaseStanza):
    """Lines of text, one frame per line; a line ends with a line feed, with or without a carriage return."""

    start: Annotated[str, Field(max_length=16)] = Field(default="", description="each line begins with it")
    separator: Annotated[str, Field(min_length=1, max_length=1)] = Field(
        default=",", description="between two fields; a blank: any number of blanks"
    )
    equals: Annotated[str, Field(min_length=1, max_length=1)] = Field(
        default="=", description="between key and value, where values have keys"
    )
    checksum: Literal["none", "xor8", "sum8", "crc8", "crc16-modbus", "crc16-ccitt"] = Field(
        default="none", description="hexadecimal, after checksum_mark, over all between start and the mark"
    )
    checksum_mark: Annotated[str, Field(min_length=1, max_length=1)] = Field(
        default="*", description="in front of the checksum"
    )
    ask: Ask = None


class JsonFrame(BaseStanza):
    """Lines of JSON, one object and one frame per line."""

    ask: Ask = None


class RecordFrame(BaseStanza):
    """Binary records of a fixed length."""

    framing: Literal["start", "cobs", "slip"] = Field(
        default="start",
        description="start: bytes that begin each record; cobs, slip: a delimiter between them",
    )
    start: Hexadecimal | None = Field(default=None, description="framing: start: those bytes, such as AA55")
    length: Annotated[int, Field(ge=1, le=256)] = Field(
        description="bytes of a record, without the start bytes and the checksum"
    )
    checksum: Literal["none", "xor8", "sum8", "crc8", "crc16-modbus", "crc16-ccitt", "crc32"] = Field(
        default="none", description="after the record, over all its bytes (not over the start bytes)"
    )
    checksum_order: ByteOrder = Field(default="little", description="which byte of the checksum comes first")


class ModbusFrame(BaseStanza):
    """Modbus RTU or TCP: the HAL requests values, and the devices on the bus answer."""

    timeout_ms: Annotated[int, Field(ge=1, le=5000)] = Field(
        default=30, description="longest wait for an answer"
    )
    pause_ms: Annotated[int, Field(ge=0, le=1000)] = Field(
        default=0,
        description="least time between an answer and the next request, for a device that needs more than the silence "
        "of the standard",
    )
    gap: Annotated[int, Field(ge=0, le=64)] = Field(
        default=8, description="channels with at most so many other registers between them are read together"
    )


class LinkFrame(BaseStanza):
    """The frame format of a link, declared here instead of by a codec's name: one of text, json, record, modbus."""

    text: TextFrame | None = Field(default=None, description="lines of text")
    json_: JsonFrame | None = Field(default=None, alias="json", description="lines of JSON")
    record: RecordFrame | None = Field(default=None, description="binary records")
    modbus: ModbusFrame | None = Field(default=None, description="registers and coils that are asked for")

    FORMATS: ClassVar = ("text", "json", "record", "modbus")

    @property
    def format(self) -> str:
        """Format of the frame, one of `FORMATS`: the first that is written; empty if none is."""
        return next((name for name in self.FORMATS if part_of(self, name) is not None), "")

    @property
    def checked(self) -> bool:
        """Whether a byte that was changed or lost in transmission is detected."""
        declared = self.text or self.record
        return self.json_ is None and (declared is None or declared.checksum != "none")


class Inputs(BaseStanza):
    """How the inputs of the board are read, if a channel comes from one."""

    period_ms: Annotated[int, Field(ge=1, le=1000)] = Field(
        default=20, description="period at which inputs are read; digital inputs are also read at each edge"
    )
    iio: Word = Field(default="/sys/bus/iio/devices", description="folder of the analog devices")


Channels = dict[Name, Channel]
