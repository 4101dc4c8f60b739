"""A controller in real time, with its thread, jobs, statuses and connection to the line arbiter."""

from ._inline_worker import InlineWorker
from ._latest_status import LatestStatus
from ._maintenance_drive import proof
from ._open_program import open_program
from ._program import Program
from ._release_proof import longest_release_s, release_is_decided
