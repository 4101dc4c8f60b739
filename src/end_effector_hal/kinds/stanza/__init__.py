"""What the stanzas of a description are made of: a frozen base, values with units, endings, the air of a tool."""

from ._actuator import Actuator
from ._endings import (
    ChangerEndings,
    Endings,
    GrippingEndings,
    HeldEndings,
    OwnEndings,
    OwnGrippingEndings,
    OwnHeldEndings,
    ProgramEnding,
)
from ._part import (
    NO_CHANNEL,
    PRINTABLE,
    BelowAmbient,
    Kilopascal,
    LineName,
    MaybeSeconds,
    Name,
    Names,
    Part,
    RosName,
    Samples,
    Seconds,
    Texts,
    Word,
)
from ._tool import Hold, Supply

__all__ = [
    "NO_CHANNEL",
    "PRINTABLE",
    "Actuator",
    "BelowAmbient",
    "ChangerEndings",
    "Endings",
    "GrippingEndings",
    "HeldEndings",
    "Hold",
    "Kilopascal",
    "LineName",
    "MaybeSeconds",
    "Name",
    "Names",
    "OwnEndings",
    "OwnGrippingEndings",
    "OwnHeldEndings",
    "Part",
    "ProgramEnding",
    "RosName",
    "Samples",
    "Seconds",
    "Supply",
    "Texts",
    "Word",
]
