"""The building blocks of stanzas: a frozen base, value types with units, endings, compressed air."""

from ._conditions import Condition, EvidenceConditions, stanza_fault
from ._endings import (
    ChangerEndings,
    Endings,
    OwnEndings,
)
from ._part import (
    NO_CHANNEL,
    PRINTABLE,
    BelowAmbient,
    Kilopascal,
    LineName,
    MaybeMillimetres,
    MaybeSeconds,
    Name,
    Names,
    Part,
    RosName,
    Samples,
    Seconds,
    Settling,
    Texts,
    Word,
    named,
)
from ._registers import Activation, Handshake, RegisterOutput
from ._tool import Actuator, BlowOff, Hold, Opposite, Supply

__all__ = [
    "NO_CHANNEL",
    "PRINTABLE",
    "Activation",
    "Actuator",
    "BelowAmbient",
    "BlowOff",
    "ChangerEndings",
    "Condition",
    "Endings",
    "EvidenceConditions",
    "Handshake",
    "Hold",
    "Kilopascal",
    "LineName",
    "MaybeMillimetres",
    "MaybeSeconds",
    "Name",
    "Names",
    "Opposite",
    "OwnEndings",
    "Part",
    "RegisterOutput",
    "RosName",
    "Samples",
    "Seconds",
    "Settling",
    "Supply",
    "Texts",
    "Word",
    "named",
    "stanza_fault",
]
