"""What a UPPAAL file says when it is valid, and everything that is found wrong with it at once."""

from ._channel_ends import ChannelEnds, channel_ends
from ._find_faults import find_faults, query_faults

__all__ = ["ChannelEnds", "channel_ends", "find_faults", "query_faults"]
