"""What a UPPAAL file says when it is valid, and everything that is found wrong with it at once."""

from ._channel_ends import ChannelEnds, channel_ends
from ._find_faults import checked_query, find_faults

__all__ = ["ChannelEnds", "channel_ends", "checked_query", "find_faults"]
