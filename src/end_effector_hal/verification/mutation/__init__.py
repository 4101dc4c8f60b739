"""Whether the requirements bind the automata: systematic edits of what is executed, and which requirement notices."""

from ._judge import Baseline, MutantOutcome, MutantVerdict, judge
from ._judge_all import Baselines, judge_all
from ._record import (
    CHECKS,
    MutationRecord,
    kept_record,
    mutation_record,
    read_record,
)
