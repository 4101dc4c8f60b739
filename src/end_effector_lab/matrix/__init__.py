"""Every fault of the testbench at every moment of a run, with every command: the outcomes, and the allowed ones."""

from ._cells import COMMANDS, Cell, Outcome, cells_of, faults_of, thinned
from ._expected import LYING, expected
from ._fmea import fmea, signed_cells
from ._play import outcome_of, play
from ._report import let_go, page, summary
from ._run import FIGURES, FMEA, PAGE, matrix_folder, no_log, play_all
from ._script import AT_REST, GRIP, HELD, RELEASE, REST, Moment, is_still, moments
from ._timeline import cell_folder, disturbances, record
