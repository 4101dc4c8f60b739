"""Random sequences of commands, faults and deaths: what they reach, and the smallest case of what fails."""

from ._case import Case, Happening, case_from_json, case_from_words, read_case
from ._coverage import CoverageMap, Reached
from ._draw import CaseSource
from ._play import CaseEnd, PlayedCase, play_case
from ._processes import play_on_processes
from ._report import never_reached, summary
from ._run import UNREACHED, Campaign, campaign_folder, kind_of_failure, read_failures, run_campaign
from ._shrink import shrunk, shrunk_by

__all__ = [
    "UNREACHED",
    "Campaign",
    "Case",
    "CaseEnd",
    "CaseSource",
    "CoverageMap",
    "Happening",
    "PlayedCase",
    "Reached",
    "campaign_folder",
    "case_from_json",
    "case_from_words",
    "kind_of_failure",
    "never_reached",
    "play_case",
    "play_on_processes",
    "read_case",
    "read_failures",
    "run_campaign",
    "shrunk",
    "shrunk_by",
    "summary",
]
