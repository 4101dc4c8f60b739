"""Rules that no single value can break: between stanzas, and between a description and its codec."""

from ._order import order_faults
from ._outputs import lost_by_silence, output_faults
from ._shared import shared_faults
from ._stanzas import limit_faults, rule_faults
from .evidence import (
    BIT,
    CodecChannels,
    Spans,
    SpanSearch,
    Wanted,
    measures_of,
    not_fitted,
    range_kpa,
    slow,
    unproven,
    used_channels,
    widest,
)
from .frames import channel_faults, frame_faults
