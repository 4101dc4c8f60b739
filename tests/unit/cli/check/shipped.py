"""The shipped description, other codecs for it, and what is said of it."""

from __future__ import annotations

import re
from collections.abc import Callable

from click.testing import Result

from end_effector_hal.description import profile_path

SHIPPED = profile_path().read_text(encoding="utf-8")
Check = Callable[..., Result]

EXCERPT = re.compile(r" *\d* \|( |$)")


def sentences(result: Result) -> list[str]:
    """What is wrong, without the lines of the file and the marks below."""
    return [line for line in result.stderr.splitlines() if not EXCERPT.match(line)]


NO_E_STOP = "no e-stop in the description: IL-13 covers only the software stop"

NIBBLE = {
    "codec: ees1-ascii ": "codec: legacy-nibble ",
    "channel: cylinder\n": "channel: none\n    retracted_bit: none\n",
    "  service: SetToolChanger": "  stand_bit: none\n  present_bit: none",
    "supply:\n": "supply:\n  channel: none\n",
}
"""The shipped tool with the prototype's byte: what that does not carry is declared as none."""
TRANSMITTERS = {
    "codec: ees1-ascii ": "codec: modbus-rtu-transmitters ",
    "channel: cylinder\n": "channel: cylinder\n    extended_bit: none\n    retracted_bit: none\n",
    "  service: SetToolChanger": "  locked_bit: none\n  unlocked_bit: none\n  stand_bit: none\n  present_bit: none",
}
