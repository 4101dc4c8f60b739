"""The proof: every requirement of a UPPAAL file, what queries cannot say, and the worst cases."""

from ._counterexample import write_counterexample
from ._finding import Finding, Proof, Requirement, WorstCase, requirements_of
from ._prove import Progress, prove

__all__ = [
    "Finding",
    "Progress",
    "Proof",
    "Requirement",
    "WorstCase",
    "prove",
    "requirements_of",
    "write_counterexample",
]
