"""Rules for evidence: whether the codecs' channels can prove all that the tool needs."""

from ._channels import CodecChannels, used_channels
from ._codec import not_fitted, slow, unproven
from ._measures import measures_of
from ._span_search import BIT, Spans, SpanSearch, Wanted, range_kpa, widest
