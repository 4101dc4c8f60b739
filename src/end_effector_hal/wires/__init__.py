"""The wires of an end-effector: lines (binary outputs) and links (sensor frames)."""

from ._claim import Claim, program_name
from ._clock import now_us
from ._steady import be_steady

__all__ = ["Claim", "be_steady", "now_us", "program_name"]
