"""Fault injection by the page: choose, arm, go. Only the page that armed can start, within 10 s and once."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.faults import NOMINAL

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
