"""Evidence by conditions over channels, in three-valued logic: one detector for all kinds with conditions."""

from ._detector import ConditionDetector
from ._judge import ConditionJudge
from ._presets import part_conditions
from ._words import asked, shown
