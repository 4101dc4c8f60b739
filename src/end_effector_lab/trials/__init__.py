"""Cases of commands, faults, deaths and restarts, played in virtual time and judged.

A grid plays every fault at every moment with every command; a campaign plays random sequences.
"""

from ._campaign import (
    UNREACHED,
    Campaign,
    kind_of_failure,
    never_reached,
    read_failures,
    run_campaign,
    summary,
)
from ._case import Case, Happening, Outcome, case_from_json, case_from_words, read_case
from ._coverage import CoverageMap
from ._draw import CaseSource, shrunk_by
from ._effects import GRIP, HELD, RELEASE, REST, Effects, FaultWords
from ._grid import COMMANDS, Cell, Moment, cells_of, moments, thinned
from ._play import no_log, play_case
from ._report import figures, fmea, let_go, page
from ._run_grid import (
    CELLS,
    FIGURES,
    FMEA,
    PAGE,
    Played,
    disturbances,
    play,
    play_all,
    record,
)
