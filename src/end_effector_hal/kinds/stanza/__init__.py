"""The building blocks of stanzas: a frozen base, value types with units, endings, compressed air."""

from ._base import (
    NO_CHANNEL,
    PRINTABLE,
    BaseStanza,
    BelowAmbient,
    Kilopascal,
    MaybeMillimetres,
    Name,
    Names,
    RosName,
    Samples,
    Seconds,
    Settling,
    Texts,
    Word,
    named,
)
from ._conditions import Condition, EvidenceConditions, stanza_fault
from ._endings import ChangerEndings, Endings, OwnEndings
from ._line import LineAddress, LineName, line_text
from ._output import Output
from ._registers import Activation, Handshake, RegisterOutput, lowest_bit
from ._tool import Actuator, BlowOff, Hold, Opposite, Supply

__all__ = [
    "NO_CHANNEL",
    "PRINTABLE",
    "Activation",
    "Actuator",
    "BaseStanza",
    "BelowAmbient",
    "BlowOff",
    "ChangerEndings",
    "Condition",
    "Endings",
    "EvidenceConditions",
    "Handshake",
    "Hold",
    "Kilopascal",
    "LineAddress",
    "LineName",
    "MaybeMillimetres",
    "Name",
    "Names",
    "Opposite",
    "Output",
    "OwnEndings",
    "RegisterOutput",
    "RosName",
    "Samples",
    "Seconds",
    "Settling",
    "Supply",
    "Texts",
    "Word",
    "line_text",
    "lowest_bit",
    "named",
    "stanza_fault",
]
