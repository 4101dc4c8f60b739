"""Finds lines that an earlier arbiter left active and that a new description lacks or gives another role."""

from __future__ import annotations

from end_effector_hal.arbiter.rules._policy import Policy
from end_effector_hal.arbiter.rules._session import ArbiterState

DROP_FIRST = (
    "Drop first: restore the former description, start the line arbiter and the programs with it, Drop (or switch the "
    "output off), and end them. Then change the description. Until then no line is touched."
)
UNKNOWN_ROLES = (
    "No record says what the lines drove before the start, because {}: an unlock is refused until a reset. Look at the "
    "outputs before you reset."
)


def left_behind(state: ArbiterState, policy: Policy) -> str:
    """Return a sentence about lines that may be active in a role that the policy lacks; empty: there are none."""
    found = []
    for line, (role, active) in state.driven.items() if policy.roles else ():
        now = policy.roles.get(line)
        if active and (now is None or now.words != role):
            found.append(f"{line} was {role} and is {now.words if now else 'no output'} in this description")
    return (
        f"The description has changed while an output is, or may be, active: {'; '.join(found)}."
        if found
        else ""
    )
