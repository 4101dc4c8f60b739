"""The messages on a testbench's socket: JSON lines. A client needs neither the testbench nor its faults to speak it.

From the testbench, ``{"kind": …, "content": {…}}``: first the ``header`` (which tool it simulates, and the faults that
this tool can have), then ``scenario``, what is wrong now: at each change, and each 0.4 s as a sign of life.

To the testbench: ``{"id": any, "word": "check", "scenario": text, "until_us": µs}`` asks whether it could play this
scenario, ``"word": "choose"`` has it played from now on. The answer is ``{"kind": "answer-to", "id": …,
"accepted": …, "reason": …}``. After ``until_us`` on the monotonic clock (at most 2 s from now) nothing is chosen any
more.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass
from pydantic_core import to_json

from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import UsageError

NOMINAL = "nominal"
"""The scenario in which nothing is wrong."""
MOST_TEXT = 300
"""Letters of a scenario."""
LONGEST = 2_000
"""Bytes of a message to the testbench: any scenario fits, however it is escaped."""
VALID_US = 2_000_000
ALIVE_US = 400_000


def socket_of_testbench(description: Description) -> Path:
    """The socket of a tool's testbench: beside that of the line arbiter; raises WireError as `socket_path` does."""
    arbiter = socket_path(description)
    return arbiter.with_name(f"{arbiter.name}.testbench")


@dataclass(frozen=True, slots=True)
class FaultNumber:
    """A number that belongs to a fault, with its limits; ``default``: it may be left out; ``whole``: no fraction."""

    name: str
    low: float
    high: float
    default: float | None = None
    whole: bool = False


@dataclass(frozen=True, slots=True)
class FaultOffer:
    """A fault that a tool can have.

    Args:
        name: as it stands in a scenario, ``name[:place][:number]``.
        meaning: a phrase for people.
        usage: how it is written.
        places: the actuators, links or channels that can have it.
        anywhere: the place may be left out.
        number: what else is to be given.
    """

    name: str
    meaning: str
    usage: str
    places: tuple[str, ...] = ()
    anywhere: bool = True
    number: FaultNumber | None = None


@dataclass(frozen=True, slots=True)
class TestbenchHeader:
    """Which tool is simulated: its name, the hash of its description, and what can go wrong with it."""

    __test__ = False  # no test class, whatever pytest thinks of its name

    tool: str
    hash: str
    faults: tuple[FaultOffer, ...]


@dataclass(frozen=True, slots=True)
class TestbenchScenario:
    """What is wrong now, as text."""

    __test__ = False

    scenario: str


@dataclass(frozen=True, slots=True)
class FaultRequest:
    """What a client asks: whether a scenario could be played, or to play it."""

    id: Annotated[int, Field(ge=0, le=2**53)]
    word: Literal["check", "choose"]
    scenario: Annotated[str, Field(max_length=MOST_TEXT)]
    until_us: Annotated[int, Field(ge=0, le=2**62)]


_REQUEST = TypeAdapter(FaultRequest)


def read_fault_request(line: bytes) -> FaultRequest:
    """Raises UsageError."""
    try:
        return _REQUEST.validate_json(line, strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"])) or "message"
        raise UsageError(f"This is not a request to a testbench: {place}: {first['msg']}.") from None


def message_line(content: TestbenchHeader | TestbenchScenario) -> bytes:
    """What the testbench says of itself."""
    kind = "header" if isinstance(content, TestbenchHeader) else "scenario"
    return to_json({"kind": kind, "content": content}) + b"\n"


def answer_line(number: int | None, *, accepted: bool, reason: str = "") -> bytes:
    """What became of a request; ``number`` None: it belongs to none."""
    said = {"kind": "answer-to", "id": number, "accepted": accepted, "reason": reason, "decided": True}
    return to_json(said) + b"\n"
