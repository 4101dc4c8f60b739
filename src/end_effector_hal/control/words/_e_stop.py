"""Why nothing is activated while nobody can read the e-stop."""

from __future__ import annotations

from end_effector_hal.codecs import carrier_of, sources_of
from end_effector_hal.description import Description
from end_effector_hal.signals import ChannelReadings


def unread_e_stop(description: Description, readings: ChannelReadings, at: int) -> str:
    """That a fitted e-stop has no valid reading at ``at`` µs, a sentence; empty: it has, or none is fitted.

    The line arbiter refuses each activation then (IL-13), so that a grip would begin only to fail.
    """
    e_stop = description.e_stop
    if e_stop is None or e_stop.channel not in readings.carried:
        return ""
    if readings.get(e_stop.channel, at) is not None:
        return ""
    where = _source(description, e_stop.channel)
    return f"IL-13: the e-stop has no valid reading ({e_stop.channel}, {where}): nothing is activated until it has one."


def _source(description: Description, channel: str) -> str:
    declared = description.channels.get(channel)
    if declared is not None and declared.on_board:
        return "inputs of the board"
    sources = sources_of(carrier_of(description))
    return description.link_name(next(each.link for each in sources if channel in each.channels) or "")
