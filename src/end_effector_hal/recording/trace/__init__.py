"""Traces: all inputs and outputs of a program, in MCAP files that can be replayed."""

from ._trace_file import Record, TraceFile, read_trace
from ._trace_writer import Gap, Opening, TraceWriter
