"""Edit the automata systematically, and find which requirement detects each edit."""

from ._edits import Mutant, mutants
from ._equivalence import ReachedNetwork
from ._judge import Baseline, MutantOutcome, MutantVerdict, judge
from ._judge_all import Baselines, judge_all
from ._record import document_of, mutation_record, text_of
