"""``eehal listen``: shows live what arrives on each channel of a tool, and proposes thresholds from a recording."""

from ._hearing import OpenLink, open_link, why_no_frame
