"""Makes the recordings of this folder importable; names of test modules need not be unique."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
