"""Rules for links: their frames, the channels in them, and the place of each channel in its frame."""

from ._declared import channel_faults
from ._frames import frame_faults, link_of
