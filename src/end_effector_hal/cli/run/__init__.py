"""``eehal run``: one tool in this terminal, its prompt and what it tells."""

from ._simulation import possible_scenarios
