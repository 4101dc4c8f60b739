"""What the arbiter answers to ``status``."""

from __future__ import annotations

from typing import Any

from end_effector_hal.arbiter.rules import LineArbiter


def status_report(arbiter: LineArbiter, at: int) -> dict[str, Any]:
    """Which client writes which lines, what the sensors were said to prove, and what is latched, at ``at`` µs."""
    needs = (need for needs in arbiter.policy.needs.values() for need in needs)
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
            for session in arbiter.sessions
        ],
        "trips": [{"at": when, "line": line, "interlock": "IL-03"} for when, line in arbiter.trips],
        "needs": sorted({need.predicate for need in needs}),
        "told": {
            name: {"holds": proof.holds, "age_us": at - proof.at}
            for name, proof in arbiter.predicates.proofs.items()
        },
        "faults": dict(arbiter.predicates.faults),
    }
