"""The faults of a simulated tool: what a testbench offers, and the messages on its socket (`wires.rpc`).

A client needs neither the testbench nor its faults to use them.

The first record from the testbench is the ``header``: which tool it simulates, and the faults that this tool can have.
Then comes ``scenario``, what is wrong now: at each change, and each 0.4 s as a sign of life.

A request with the word ``check`` asks whether the testbench could play a scenario; ``choose`` plays it from now on.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from end_effector_hal.description import Description, socket_path
from end_effector_hal.wires.rpc import RpcRequest

NOMINAL = "nominal"
"""The scenario in which nothing is wrong."""
MOST_TEXT = 300
"""The largest number of letters of a scenario."""
LONGEST = 2_000
"""Bytes of a message to the testbench: any scenario fits, however it is escaped."""


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
    """The simulated tool: its name, the hash of its description, and its possible faults."""

    __test__ = False  # no test class for pytest

    tool: str
    hash: str
    faults: tuple[FaultOffer, ...]


@dataclass(frozen=True, slots=True)
class TestbenchScenario:
    """The scenario that plays now, as text."""

    __test__ = False

    scenario: str


TESTBENCH_RECORDS: dict[str, type] = {"header": TestbenchHeader, "scenario": TestbenchScenario}


@dataclass(frozen=True, slots=True)
class FaultRequest(RpcRequest):
    """A request to check a scenario, or to play it."""

    word: Literal["check", "choose"]
    scenario: Annotated[str, Field(max_length=MOST_TEXT)]
