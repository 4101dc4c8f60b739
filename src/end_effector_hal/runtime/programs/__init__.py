"""Controllers in real time: every program with its thread, jobs, statuses and connection to the line arbiter."""

from ._changer_program import ChangerProgram, longest_release_s, release_is_decided
from ._grip_program import GripProgram
from ._inline_worker import InlineWorker
from ._open_program import open_program
from ._program import Program
