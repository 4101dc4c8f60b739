"""The table of alarms: their ids, severities and texts."""

from __future__ import annotations

import re

from end_effector_hal.vocabulary import ALARMS

from ._markdown import plain, table


def alarms() -> str:
    """All of them, in the order of the program."""
    rows = [
        (f"`{name}`", each.severity, " Or: ".join(map(_shown, each.texts)), _shown(each.over))
        for name, each in ALARMS.items()
    ]
    return table(("Id", "Severity", "Text", "When it is over"), rows)


def _shown(template: str) -> str:
    return plain(re.sub(r"\{(\w+)[^}]*\}", r"`\1`", template))
