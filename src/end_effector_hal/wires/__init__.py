"""The wires of an end-effector: lines (binary outputs), links (sensor frames), and all that brings readings."""

from ._claim import Claim
from ._clock import be_steady, now_us
from ._processes import Holder, holders_of, program_name

__all__ = ["Claim", "Holder", "be_steady", "holders_of", "now_us", "program_name"]
