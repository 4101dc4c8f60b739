"""Detectors of no single kind: frozen sensors, release of everything, supply, tool changer."""

from ._frozen import FrozenDetector
from ._release import ReleaseDetector
from ._supply import SupplyDetector
from ._tool import ToolDetector
