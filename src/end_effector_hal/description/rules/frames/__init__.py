"""Rules for links: their frames, the channels in them, and where each stands."""

from ._declared import channel_faults
from ._frames import frame_faults, link_of
