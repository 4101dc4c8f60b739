"""The pins of the emulated Verdin that a tool uses."""

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_lab.testbench import lines_of

VERDIN = {"SODIMM_206": 0, "SODIMM_208": 1, "SODIMM_210": 5, "SODIMM_212": 6}
"""Pins of the first GPIO controller of an i.MX 8M Plus, by the names that the Verdin's device tree gives them."""


def pins_of(description: Description) -> dict[str, int]:
    """Return the pin of each line of a tool; raise UsageError for a line that the Verdin does not have."""
    lines = lines_of(description)
    if unknown := [line for line in lines if line not in VERDIN]:
        raise UsageError(
            f"the emulated Verdin has no line {', '.join(unknown)}.", todo=f"It has {', '.join(VERDIN)}."
        )
    return {line: VERDIN[line] for line in lines}
