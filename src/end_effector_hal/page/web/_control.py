"""The control lease, which one page has while others watch; and fault injection in steps (choose, arm, go)."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.faults import NOMINAL

LEASE_US = 10_000_000


class ControlLease:
    """A lease held by one page; times in µs. It does not lock out ROS clients or the prompt."""

    def __init__(self) -> None:
        self._holder = self._name = ""
        self._until = 0

    def holder(self, at: int) -> str:
        """Return the page that has the control; empty if none has."""
        return self._holder if at < self._until else ""

    def take(self, page: str, name: str, at: int) -> Answer:
        """Give the control to a page, or renew its lease."""
        if (holder := self.holder(at)) and holder != page:
            left_s = (self._until - at) / 1e6
            return Answer(
                False, f"{self._name} has the control until it releases it or is silent for {left_s:.0f} s."
            )
        self._holder, self._name, self._until = page, name, at + LEASE_US
        return Answer(True)

    def renew(self, page: str, at: int) -> bool:
        """Renew the control; return whether the page still had it."""
        if self.holder(at) != page:
            return False
        self._until = at + LEASE_US
        return True

    def release(self, page: str, at: int) -> None:
        """Release the control; this ends nothing else."""
        if self.holder(at) == page:
            self._until = at

    def shown(self, at: int) -> dict[str, Any]:
        """Return the state of the control, as shown on every page."""
        holder = self.holder(at)
        return {
            "holder": holder,
            "name": self._name if holder else "",
            "left_s": max(0, self._until - at) / 1e6,
        }


ARMED_US = 10_000_000
FAULT_WORDS = ("arm", "go", "nominal")
ARM_FIRST = "Arm a scenario first: none is armed, or it was armed more than 10 s ago."


@dataclass(frozen=True)
class _Armed:
    page: str
    name: str
    scenario: str
    until: int


class FaultCommands:
    """Handles fault commands; times in µs. The caller checks that the page may command.

    Args:
        ask: sends ``check`` or ``choose`` with a scenario to the testbench.
        there: returns whether a testbench is connected.
    """

    def __init__(self, ask: Callable[[str, str], Awaitable[Answer]], there: Callable[[], bool]) -> None:
        self._ask, self._there = ask, there
        self._armed: _Armed | None = None

    async def obey(self, word: str, page: str, name: str, scenario: str, now: Callable[[], int]) -> Answer:
        """Execute one of `FAULT_WORDS`.

        Args:
            word: the word.
            page: the page that asks.
            name: the page's name, shown to the others.
            scenario: the scenario to arm, or the one that the page assumes to be armed.
            now: the clock.
        """
        if not self._there():
            return Answer(False, "No testbench is at the other end of the wires.")
        if word == "nominal":
            self._armed = None
            return await self._ask("choose", NOMINAL)
        if word == "arm":
            self._armed = None
            answer = await self._ask("check", scenario)
            if answer.accepted:
                self._armed = _Armed(page, name, scenario, now() + ARMED_US)
            return answer
        armed = self._now_armed(now())
        if armed is None or armed.page != page:
            return Answer(False, ARM_FIRST)
        if armed.scenario != scenario:
            return Answer(False, f"Another scenario is armed: {armed.scenario}.")
        self._armed = None
        return await self._ask("choose", scenario)

    def shown(self, at: int) -> dict[str, Any] | None:
        """Return the armed scenario, as shown on every page; None if nothing is armed."""
        armed = self._now_armed(at)
        if armed is None:
            return None
        left_s = (armed.until - at) / 1e6
        return {"page": armed.page, "name": armed.name, "scenario": armed.scenario, "left_s": left_s}

    def _now_armed(self, at: int) -> _Armed | None:
        if self._armed is not None and (at >= self._armed.until or not self._there()):
            self._armed = None
        return self._armed
