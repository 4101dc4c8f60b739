"""Properties that searches decide: queries, worst cases, coverage, divergence of time."""

from ._coverage_report import Coverage
