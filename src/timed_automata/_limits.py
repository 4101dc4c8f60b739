"""Limits on the size of a UPPAAL file; a larger file is refused with a message before it costs time or memory."""

from __future__ import annotations

FILE_BYTES = 500_000
XML_DEPTH = 16
"""Largest nesting depth of XML elements."""
XML_ELEMENTS = 20_000
TEXT_CHARACTERS = 65_536
"""Largest length of one declaration or label, characters."""
NESTING = 500
"""Largest number of nested brackets, of signs before one operand, or of operators in a row."""
DIGITS = 10
"""Largest number of digits of a number; UPPAAL computes with 32 bits."""
LONGEST_BITS = 64
"""Largest size of a constant that is computed from other constants, bits."""
REPEATS = 10_000
"""Largest number of values that nested quantifiers and loops run through, including those of called functions."""
SELECTED = 10_000
"""Largest number of combinations of selected values of one edge."""
ELEMENTS = 100_000
"""Largest number of declared scalars and array elements in total."""
PROCESSES = 1_000
"""Largest number of processes on the system line."""
PARTS = 50_000
"""Largest number of locations and edges of all processes; an edge counts once for each value that it selects."""
