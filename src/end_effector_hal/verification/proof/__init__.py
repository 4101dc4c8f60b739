"""The proof: every requirement of a UPPAAL file, what queries cannot say, and the worst cases."""

from ._counterexample import write_counterexample
from ._finding import Finding, Proof, Requirement, WorstCase, requirements_of
from ._prove import Progress, prove
from ._verdict import Verdict, keep_verdict, kept_verdict, proof_verdict

__all__ = [
    "Finding",
    "Progress",
    "Proof",
    "Requirement",
    "Verdict",
    "WorstCase",
    "keep_verdict",
    "kept_verdict",
    "proof_verdict",
    "prove",
    "requirements_of",
    "write_counterexample",
]
