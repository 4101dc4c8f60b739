"""The proof: every requirement of a UPPAAL file, what queries cannot say, and the worst cases."""

from ._counterexample import write_counterexample
from ._finding import Finding, Proof, WorstCase
from ._prove import Progress, prove
from ._requirement import Requirement, requirements_of

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
