"""From a status to levels and a last will, and those to the line arbiter: what is written, refused, tried again."""

from ._maintenance import Maintenance
from ._output_mapping import ChangerOutputs, GripOutputs, OutputMapping
from ._outputs import DECLARED_DEAD, RESTARTED, RETRY_US, LineWriter, Outputs, unknown
