"""Evidence by conditions over channels, three-valued and pure: one detector for every kind that is described so."""

from ._detector import ConditionDetector
from ._judge import ConditionJudge
from ._presets import part_conditions
from ._words import asked, shown
