"""What a campaign has come to: its figures, and what it has never reached."""

from __future__ import annotations

from typing import Any

from ._run import Campaign


def summary(campaign: Campaign) -> dict[str, Any]:
    """The figures, for one line of JSON; shares as ``reached/all``."""
    reached, known = campaign.reached, campaign.known
    return {
        "runs": campaign.runs,
        "failures": campaign.failures,
        "kinds": len(campaign.kinds),
        "grips": campaign.grips,
        "virtual_s": round(campaign.seconds),
        "edges": f"{len(reached.edges)}/{len(known.edges)}",
        "locations": f"{len(reached.locations)}/{len(known.locations)}",
        "edge_faults": f"{len(reached.pairs)}/{len(known.edges) * len(known.faults)}",
        "kept": len(campaign.kept),
        "seed": campaign.seed,
    }


def never_reached(campaign: Campaign) -> dict[str, Any]:
    """Edges and locations that no run has reached, and by fault the edges that no run has taken with it."""
    reached, known = campaign.reached, campaign.known
    by_fault = {
        fault: [
            name for edge, name in enumerate(known.edges) if known.pair(edge, number) not in reached.pairs
        ]
        for number, fault in enumerate(known.faults)
    }
    return {
        "edges": [name for number, name in enumerate(known.edges) if number not in reached.edges],
        "locations": [name for number, name in enumerate(known.locations) if number not in reached.locations],
        "edge_faults": by_fault,
    }
