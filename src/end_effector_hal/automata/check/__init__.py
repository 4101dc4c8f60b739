"""What a UPPAAL file says when it is valid, and everything that is found wrong with it at once."""

from end_effector_hal.automata.check._ends import Ends, ends_of
from end_effector_hal.automata.check._faults_of import faults_of

__all__ = ["Ends", "ends_of", "faults_of"]
