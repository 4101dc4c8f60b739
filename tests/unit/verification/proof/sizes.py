"""Descriptions of tools of any size: vacuums and cylinders in turn, each step with times of its own."""

from __future__ import annotations


def sized(count: int) -> str:
    """A description with so many actuators, and bounds that are just wide enough."""
    names = [f"{'cylinder' if at % 2 else 'vacuum'}_{at}" for at in range(count)]
    late, decided, released, actuators = 0.05, 0.0, 0.0, []
    for at, name in enumerate(names):
        attempts, confirm, pause, gone = 1 + at % 3, 2 + at % 4, 0.5 + at % 2, 1 + at % 3
        decided += attempts * (confirm + late) + (attempts - 1) * (pause + late)
        released += gone + late
        bits = f", extended_bit: out_{at}, retracted_bit: in_{at}" if at % 2 else ""
        actuators.append(
            f"  {name}: {{kind: {name.split('_')[0]}, line: LINE_{at}, channel: sensor_{at}, service: Set{at},"
            f" topic: Topic{at}, timeout_s: {confirm}, reset_s: {pause}, attempts: {attempts},"
            f" release_s: {gone}{bits}}}"
        )
    return "\n".join(
        (
            f"name: tool_of_{count}",
            "lines: {backend: gpiod}",
            "link: {port: /dev/ttyS1, codec: ees1-ascii}",
            f"sequence: [{', '.join(names)}]",
            "actuators:",
            *actuators,
            "tool_changer: {line: LINE_LOCK, service: SetLock}",
            f"bounds: {{grip_s: {decided + released:.2f}, release_s: {released:.2f}, cancel_s: {released:.2f}}}",
            "",
        )
    )
