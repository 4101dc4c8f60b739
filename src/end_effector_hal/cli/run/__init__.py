"""``eehal run``: runs one tool in this terminal, with a prompt and its messages."""

from ._simulation import possible_scenarios
