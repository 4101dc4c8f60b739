"""The sockets of the programs, as the page reads them: records in, commands out."""

from ._program_link import ProgramLink
from ._tool_link import ToolLink

__all__ = ["ProgramLink", "ToolLink"]
