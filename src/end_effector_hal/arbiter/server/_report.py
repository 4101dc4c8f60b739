"""What the owner answers to ``status``."""

from __future__ import annotations

from typing import Any

from end_effector_hal.arbiter.rules import LineArbiter


def report(keeper: LineArbiter, at: int) -> dict[str, Any]:
    """Who writes which lines, what the sensors are said to show, and what is latched, at ``at`` µs."""
    return {
        "clients": [
            {
                "client": session.client,
                "pid": session.pid,
                "lines": sorted(session.lines),
                "ended": session.ended,
                "absent": session.absent,
                "waiting": len(session.queue),
                "lease_us": max(0, session.lease_until - at),
                "will": [step.as_json() for step in session.will],
            }
            for session in keeper.sessions
        ],
        "trips": [{"at": when, "line": line, "interlock": "IL-03"} for when, line in keeper.trips],
        "needs": sorted({need.predicate for needs in keeper.policy.needs.values() for need in needs}),
        "told": {
            name: {"holds": claim.holds, "age_us": at - claim.at}
            for name, claim in keeper.sensed.claims.items()
        },
        "faults": dict(keeper.sensed.faults),
    }
