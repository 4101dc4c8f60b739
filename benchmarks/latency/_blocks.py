"""Alternating blocks of the product and of its floor, under the same load of the machine."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from usage import Meter, Usage

from end_effector_hal.errors import ReportedError

from ._driven import Driven
from ._floor import Floor
from ._hardware import Hardware
from ._matching import MatchError, Note, floor_latencies, product_latencies
from ._result import Result


@dataclass(frozen=True)
class Plan:
    """Counts of one round.

    Attributes:
        rounds: number of times that all parts are measured in sequence, each time with new processes.
        blocks: pairs of product and floor.
        cycles: grips and drops in a block; each gives 4 reactions, 2 commands, 6 states.
        floor_s: length of a block of the floor, which makes 5 reactions and 5 commands a second.
        losses: number of losses of a held part.
        hold_s: how long processor time and memory are measured while gripped.
    """

    rounds: int
    blocks: int
    cycles: int
    floor_s: float
    hold_s: float
    losses: int


FULL = Plan(rounds=4, blocks=2, cycles=4, floor_s=5.0, hold_s=10.0, losses=5)
QUICK = Plan(rounds=2, blocks=1, cycles=3, floor_s=3.0, hold_s=5.0, losses=1)


CYCLE_S = 2.0
"""Least duration of a grip and a drop."""
LONGEST_S = 30.0


def measure_blocks(
    hardware: Hardware, floor: Floor, client: Driven, notes: Path, plan: Plan, say: Callable[[str], None]
) -> Result:
    """Alternate blocks of product and floor; each block of the product begins and ends with nothing gripped."""
    result, lines = Result(), [actuator.line for _, actuator in hardware.description.ordered]
    tail, floor_tails = Tail(notes), [Tail(path) for path in floor.notes]
    client.tell("cycles 1")  # whatever is slow the first time
    client.wait_done(expected_s=CYCLE_S, timeout_s=LONGEST_S)
    floor.run(1.0, hardware.phase_us())
    for follower in (tail, *floor_tails):
        follower.new()
    for block in range(plan.blocks):
        say(f"block {block + 1} of {plan.blocks}")
        client.tell(f"cycles {plan.cycles}")
        failed = client.wait_done(expected_s=plan.cycles * CYCLE_S, timeout_s=plan.cycles * LONGEST_S)
        meter = Meter(floor.nodes)
        floor.run(plan.floor_s, hardware.phase_us())
        result.floor_usage = meter.read()
        noted, floor_noted = tail.new(), [note for each in floor_tails for note in each.new()]
        try:
            if failed:
                raise MatchError(" ".join(failed))
            pair = product_latencies(read(hardware.saw), noted, lines), floor_latencies(floor_noted)
        except MatchError as error:
            # a machine that stands still for long makes readings stale: told, and not measured
            result.left_out.append(str(error))
            say(f"left out: {error}")
        else:
            result.product.append(pair[0])
            result.floor.append(pair[1])
    if not result.product:
        raise ReportedError("No block could be measured.", todo="Is the machine very busy? Try again.")
    return result


def hold(
    client: Driven, pids: Mapping[str, int], seconds: float, say: Callable[[str], None]
) -> dict[str, Usage]:
    """Grip, and measure the usage of some processes while the part is held."""
    say(f"holding for {seconds:g} s")
    client.tell("grip")
    if failed := client.wait_done(expected_s=1.0, timeout_s=LONGEST_S):
        raise ReportedError(f"It could not be gripped: {failed[-1]}")
    meter = Meter(pids)
    time.sleep(seconds)
    return meter.read()


class Tail:
    """Reads the new notes of a file."""

    def __init__(self, path: Path) -> None:
        self._path, self._read = path, 0

    def new(self) -> list[Note]:
        notes = read(self._path)
        begin, self._read = self._read, len(notes)
        return notes[begin:]


def read(path: Path) -> list[Note]:
    """Return all complete notes of a file."""
    # the last line may not be whole yet
    return [json.loads(line) for line in path.read_text(encoding="utf-8").split("\n")[:-1]]
