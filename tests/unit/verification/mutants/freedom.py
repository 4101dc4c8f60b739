"""Edits of the shipped automata that no requirement notices, and why none needs to."""

from __future__ import annotations

NEVER_ASKED = "now() is asked only with k < N: the condition only keeps the index in its array"
AT_ONCE = "the environment asks in a committed location: nothing comes between"

FREEDOM = {
    "Gripper, function now: constant, 'N' -> '(N + 1)'": NEVER_ASKED,
    "Gripper, function now: comparison, '<' -> '<='": NEVER_ASKED,
    "Gripper, function now: condition dropped, 'k < N ? k : N - 1' -> '(k)'": NEVER_ASKED,
    "Gripper, function now: constant, 'N - 1' -> '(N - 1 + 1)'": NEVER_ASKED,
    "Gripper, function now: constant, 'N - 1' -> '(N - 1 - 1)'": NEVER_ASKED,
    "Gripper, function now: constant, '1' -> '2'": NEVER_ASKED,
    "Gripper, function now: constant, '1' -> '0'": NEVER_ASKED,
    "Changer, location Opening: urgent, 'committed' -> 'urgent'": AT_ONCE,
    "Changer, location Opening: ordinary, 'committed' -> 'ordinary'": AT_ONCE,
}
"""By the mutant in words."""
