"""The sockets of the programs and of a testbench, as the page reads them: records in, commands out."""

from ._testbench_link import TestbenchLink
from ._tool_link import ToolLink
