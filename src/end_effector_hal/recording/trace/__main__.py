"""``python -m end_effector_hal.recording.trace FILE``: what `start_indexing` starts."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from ._indexed import write_indexed

os.nice(19)
write_indexed(Path(sys.argv[1]))
