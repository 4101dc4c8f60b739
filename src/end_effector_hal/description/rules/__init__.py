"""What no single value shows: rules between stanzas, and between a description and its codec."""

from ._channels import CodecChannels, used_channels
from ._codec import not_fitted, slow, unproven
from ._declared import channel_faults
from ._frames import frame_faults
from ._limits import limit_faults
from ._measures import measures_of
from ._order import order_faults
from ._outputs import lost_by_silence, output_faults
from ._shared import shared_faults
from ._span_search import BIT, Spans, SpanSearch, Wanted, range_kpa, widest
from ._stanzas import rule_faults
