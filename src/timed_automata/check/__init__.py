"""What a UPPAAL file says when it is valid, and everything that is found wrong with it at once."""

from ._ends import Ends, ends_of
from ._faults_of import faults_of

__all__ = ["Ends", "ends_of", "faults_of"]
