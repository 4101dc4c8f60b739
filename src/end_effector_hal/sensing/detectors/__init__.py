"""What is no matter of a kind: a frozen sensor, the release of everything, the supply, the tool changer."""

from ._frozen import FrozenDetector
from ._release import ReleaseDetector
from ._supply import SupplyDetector
from ._tool import ToolDetector
