"""The faults that a testbench can simulate for a tool, and the messages on its socket (`wires.rpc`).

A client can use these messages without the testbench installed.

The first record from the testbench is the ``header``: the tool that it simulates, and the faults that this tool can
have. Then come ``scenario`` records with the faults that are active now: one at each change, and one every 0.4 s as a
sign of life.

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
"""The scenario without faults."""
MOST_TEXT = 300
"""Longest scenario text, characters."""
LONGEST = 2_000
"""Longest message to the testbench, bytes; enough for any scenario, even with every character escaped."""


def socket_of_testbench(description: Description) -> Path:
    """Return the socket path of a tool's testbench, beside that of the line arbiter.

    Raises:
        WireError: as `socket_path` does.
    """
    arbiter = socket_path(description)
    return arbiter.with_name(f"{arbiter.name}.testbench")


@dataclass(frozen=True, slots=True)
class FaultNumber:
    """A number that a fault needs, with its limits.

    With a ``default`` the number may be omitted; ``whole``: it must be an integer.
    """

    name: str
    low: float
    high: float
    default: float | None = None
    whole: bool = False


@dataclass(frozen=True, slots=True)
class FaultOffer:
    """A fault that a tool can have.

    Args:
        name: the fault's name in a scenario, ``name[:place][:number]``.
        meaning: a phrase for people.
        usage: the syntax of the fault in a scenario.
        places: the actuators, links or channels that can have the fault.
        anywhere: whether the place may be omitted.
        number: the number that the fault needs; None: it needs none.
    """

    name: str
    meaning: str
    usage: str
    places: tuple[str, ...] = ()
    anywhere: bool = True
    number: FaultNumber | None = None


@dataclass(frozen=True, slots=True)
class TestbenchHeader:
    """The simulated tool: its name, the hash of its description, its possible faults, and how each unit of a bus is
    played.
    """

    __test__ = False  # no test class for pytest

    tool: str
    hash: str
    faults: tuple[FaultOffer, ...]
    units: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TestbenchScenario:
    """The scenario that the testbench plays now, as text."""

    __test__ = False

    scenario: str


TESTBENCH_RECORDS: dict[str, type] = {"header": TestbenchHeader, "scenario": TestbenchScenario}


@dataclass(frozen=True, slots=True)
class FaultRequest(RpcRequest):
    """A request to check a scenario, or to play it."""

    word: Literal["check", "choose"]
    scenario: Annotated[str, Field(max_length=MOST_TEXT)]
