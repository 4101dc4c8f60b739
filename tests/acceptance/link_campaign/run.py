"""``make link-campaign``: what a link can do wrong, at random moments of all functions, and what must hold then."""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path

from rich.console import Console

from tests.acceptance.link_campaign.summary import as_json, holds, show
from tests.acceptance.link_campaign.virtual import CODECS, in_virtual_time
from tests.acceptance.link_campaign.wall import play_for

console = Console(width=130, highlight=False)


def main() -> int:
    arguments = _arguments()
    begun, seconds = time.monotonic(), arguments.seconds
    virtual = in_virtual_time(arguments.faults, arguments.seed, arguments.jobs)
    show(console, f"virtual time, {' and '.join(CODECS)}", virtual)
    found = {"virtual": virtual}
    if seconds:
        found["wall"] = play_for(seconds, arguments.seed)
        show(console, f"wall clock, {seconds:g} s over a pty", found["wall"])
    ok = all(map(holds, found.values())) and virtual.faults.total() >= arguments.faults
    document = {"ok": ok, "seed": arguments.seed} | {name: as_json(each) for name, each in found.items()}
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    verdict = "everything holds" if ok else "[red]not everything holds[/red]"
    console.print(f"{verdict}, {time.monotonic() - begun:.0f} s; {arguments.output}")
    return 0 if ok else 1


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faults", type=int, default=10_000, help="in virtual time")
    parser.add_argument("--seconds", type=float, default=60.0, help="in wall-clock time; 0: none")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("-o", "--output", type=Path, default=Path("runs/link-campaign.json"))
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
