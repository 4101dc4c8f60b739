"""Evidence by conditions over channels, three-valued and pure: one detector for every kind that is described so."""

from ._detector import ConditionDetector
from ._judge import ConditionJudge
from ._words import shown

__all__ = ["ConditionDetector", "ConditionJudge", "shown"]
