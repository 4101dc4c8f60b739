"""The proof: every requirement of a UPPAAL file, general checks that no query expresses, and the worst cases."""

from ._checks import CHECKS
from ._counterexample import counterexample_run, told_run, write_counterexample
from ._finding import UNMET, Finding, Proof, Requirement, WorstCase, requirements_of
from ._prove import FREE_SENSORS, Progress, free_constants, prove
from ._verdict import Verdict, keep_verdict, kept_verdict, proof_verdict

__all__ = [
    "CHECKS",
    "FREE_SENSORS",
    "UNMET",
    "Finding",
    "Progress",
    "Proof",
    "Requirement",
    "Verdict",
    "WorstCase",
    "counterexample_run",
    "free_constants",
    "keep_verdict",
    "kept_verdict",
    "proof_verdict",
    "prove",
    "requirements_of",
    "told_run",
    "write_counterexample",
]
