"""Explain in words why a requirement does not hold, with the values that it names over the run that shows it."""

from __future__ import annotations

from collections.abc import Sequence

from end_effector_hal.errors import RangeError
from timed_automata import Network
from timed_automata.explain import Explanation, Names, explain, explain_time
from timed_automata.queries import parse_query

from ._finding import Finding

_LIKE = "actuator"
_ALSO = ("cause_at",)


def names_in(network: Network, actuators: Sequence[str]) -> Names:
    """Return the names of a network's values, with those of the actuators in sequence order."""
    return Names(network, actuators, _LIKE, _ALSO)


def why(finding: Finding, names: Names) -> Explanation:
    """Return the explanation why a requirement does not hold.

    Args:
        finding: a finding with a trace.
        names: the names of the trace's network.
    """
    trace = finding.trace
    assert trace is not None
    try:
        return (
            explain(trace, parse_query(finding.query), names) if finding.query else explain_time(trace, names)
        )
    except (RangeError, ArithmeticError, LookupError, TypeError, ValueError, RecursionError):
        # the last step of the run is what leaves a range; and words never cost a verdict
        return Explanation(f"{trace.remark.rstrip('.')}.", ())
