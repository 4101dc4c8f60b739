"""Rules for evidence: whether the codecs' channels can prove all that the tool needs."""

from ._channels import CodecChannels, used_channels
from ._codec import not_fitted, slow, unproven
from ._span_search import BIT, Spans, SpanSearch, Wanted, measures_of, range_kpa, widest
