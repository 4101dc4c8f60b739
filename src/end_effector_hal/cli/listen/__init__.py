"""``eehal listen``: what arrives on each channel of a tool, live; and thresholds from what was recorded."""

from ._hearing import OpenLink, open_link, why_no_frame
