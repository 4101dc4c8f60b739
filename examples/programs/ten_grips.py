"""Grip and drop ten times, and report: a program of one's own beside a tool that `eehal serve` runs.

    python ten_grips.py my_tool.yaml [GRIPS]

It is a client only: if it ends or is killed, a running grip continues, and what is held stays held.
"""

import sys

from end_effector_hal.errors import ReportedError
from end_effector_hal.runtime import EndEffector


def main(description: str, grips: int = 10) -> int:
    """Return the exit code: 0 if the sensors have confirmed every grip and every drop."""
    seconds, dropped, first = [], 0, 0
    with EndEffector.connect(description) as tool:
        tool.wait_ready()
        if tool.status.held:
            print("A part is held already: nothing was done. Drop it first.")
            return 1
        if tool.description.tool_changer is not None and not (locked := tool.lock()).succeeded:
            print(f"Not locked: {locked.reason}")
            return 1
        for number in range(1, grips + 1):
            grip = tool.grip()
            print(f"Grip {number}: {grip.outcome.name}, {grip.seconds:.2f} s. {grip.reason}".rstrip())
            if grip.succeeded:
                seconds.append(grip.seconds)
                first += all(step.attempts <= 1 for step in grip.steps)
                if not (drop := tool.drop()).succeeded:
                    print(f"Not dropped: {drop.reason}")
                    break
                dropped += 1
    print(f"{len(seconds)} of {grips} grips confirmed, {first} at the first attempt.")
    if seconds:
        print(f"Time to grip: {min(seconds):.2f} s to {max(seconds):.2f} s.")
    return 0 if dropped == grips else 1


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1], *map(int, sys.argv[2:3])))
    except ReportedError as error:
        sys.exit(error.sentence)
