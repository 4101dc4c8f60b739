"""Systematic mutants of a UPPAAL file: each is the file with one small edit, for asking whether its queries notice."""

from ._mutants import Mutant, mutants
