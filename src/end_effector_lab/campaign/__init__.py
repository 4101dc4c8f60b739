"""Random sequences of commands, faults and deaths: measures the coverage, and finds the smallest case of every
failure.
"""

from ._campaign import Campaign, kind_of_failure, never_reached, summary
from ._case import Case, Happening, case_from_json, case_from_words, read_case
from ._coverage import CoverageMap
from ._draw import CaseSource
from ._play import play_case
from ._processes import play_on_processes
from ._run import UNREACHED, campaign_folder, read_failures, run_campaign
from ._shrink import shrunk_by
