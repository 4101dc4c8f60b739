"""Turn a status into levels and a last will, and write both to the line arbiter, with refusals and retries."""

from ._maintenance import Maintenance
from ._output_mapping import OutputMapping
from ._outputs import DECLARED_DEAD, RESTARTED, RETRY_US, LineWrite, LineWriter, Outputs, unknown
