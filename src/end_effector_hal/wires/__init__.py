"""The wires of an end-effector: lines (binary outputs), links (sensor frames), buses, and all sources of readings."""

from ._claim import Claim, Holder, holders_of, lockers_of, program_name
from ._clock import now_us, processors_awake, tune_interpreter
from ._piped_lines import PipedLines
from ._relay import RELAYED, relay_path
