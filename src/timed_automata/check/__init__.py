"""What a UPPAAL file says when it is valid, and everything that is found wrong with it at once."""

from ._channel_ends import ChannelEnds, channel_ends
from ._faults_of import faults_of

__all__ = ["ChannelEnds", "channel_ends", "faults_of"]
