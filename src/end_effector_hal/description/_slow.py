"""Times of a description that a slow link cannot keep: allowed, and told."""

from __future__ import annotations

from collections.abc import Iterator

from ._codec_channels import CodecChannels
from ._model import Description
from ._units import number


def slow(description: Description, codec: CodecChannels) -> list[str]:
    """A sentence for each time-out that may end while the link still counts what it showed before.

    A reading counts until it is stale, so that a time-out must last longer; what one attempt shows must not be
    read in the next, so that the pause between them lasts longer than a period.
    """
    return [*_ends_too_early(description, codec), *_read_twice(description, codec)]


def _ends_too_early(description: Description, codec: CodecChannels) -> Iterator[str]:
    link, period_s = description.link, codec.period_us / 1e6
    stale_s = max(link.stale_s, link.stale_periods * period_s)
    for where, key, limit_s in _awaited(description, codec):
        if limit_s <= stale_s:
            yield (
                f"{where}: {key} = {number(limit_s)} s is over before a reading of {codec.codec} is stale "
                f"({number(stale_s)} s, one each {number(period_s)} s): a late or lost frame fails it"
            )


def _awaited(description: Description, codec: CodecChannels) -> Iterator[tuple[str, str, float]]:
    """What the sensors have to show, and within which time."""
    for name, each in description.ordered:
        yield name, "timeout_s", each.timeout_s
        yield name, "release_s", each.release_s
    changer = description.tool_changer
    if changer and {changer.locked_bit, changer.unlocked_bit} <= codec.channels.keys():
        yield "tool changer", "prove_s", changer.prove_s


def _read_twice(description: Description, codec: CodecChannels) -> Iterator[str]:
    period_s = codec.period_us / 1e6
    for name, each in description.ordered:
        if each.reset_s <= period_s:
            yield (
                f"{name}: reset_s = {number(each.reset_s)} s is no longer than a period of {codec.codec} "
                f"({number(period_s)} s): what one attempt showed may confirm the next"
            )
