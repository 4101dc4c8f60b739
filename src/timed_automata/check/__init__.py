"""Finds all faults of a UPPAAL file at once, and lists the senders and receivers of its channels."""

from ._channel_ends import ChannelEnds, channel_ends
from ._find_faults import checked_query, find_faults

__all__ = ["ChannelEnds", "channel_ends", "checked_query", "find_faults"]
