"""The stored record of the judged mutants: which requirements need which edge of the automata."""

from ._record import CHECKS, KEPT_FILE, EdgeNeeds, MutationRecord, edge_key, kept_record
