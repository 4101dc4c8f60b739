"""The cost of a live page: the tool's reaction without viewers, and with a Chromium and nine event streams.

Run by hand, from the folder of the project: ``python benchmarks/watched.py``. Blocks alternate between the page's
process with all viewers, and none of them.
"""

from __future__ import annotations

import argparse
import http.client
import json
import re
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from statistics import median
from typing import Any
from urllib.parse import urlsplit

from latency import CYCLE_S, LONGEST_S, Driven, Hardware, Latencies, MatchError, Tail, product_latencies, read
from usage import Meter

from end_effector_hal.description import load, profile_path
from end_effector_lab.processes import EEHAL, Child

STREAMS = 9
COSTS_PERCENT, PAGE_PERCENT = 5.0, 15.0
START_S = 30.0


class Stream(threading.Thread):
    """Reads the events of a page as fast as they arrive."""

    def __init__(self, url: str, number: int) -> None:
        super().__init__(daemon=True)
        where = urlsplit(url)
        self._connection = http.client.HTTPConnection(where.netloc, timeout=START_S)
        self._connection.request("GET", f"{where.path}?{where.query}")
        first = self._connection.getresponse()
        cookie = (first.getheader("set-cookie") or "").split(";")[0]
        first.read()
        self._connection.request("GET", f"/events?page={number:016x}", headers={"Cookie": cookie})
        self._events = self._connection.getresponse()
        assert self._events.status == 200, self._events.status
        self.bytes = 0

    def run(self) -> None:
        """Read until the connection ends."""
        try:
            while got := self._events.read1():
                self.bytes += len(got)
        except (OSError, ValueError, AttributeError, http.client.HTTPException):
            pass  # closed meanwhile

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()


@contextmanager
def watched(hardware: Hardware, browser: Any, number: int) -> Iterator[Child]:
    """Yield the page's process when all viewers are connected."""
    page = hardware.children.start(
        f"page {number}",
        [*EEHAL, "page", str(hardware.description_path), "--port", "0"],
        log=hardware.folder / f"page-{number}.log",
    )
    address = re.compile(r"http://\S+")
    page.wait_until(lambda: address.search(page.text()), timeout_s=START_S, what="it was served")
    url = address.findall(page.text())[0]
    with ExitStack() as undo:
        undo.callback(page.end)
        tab = browser.new_page()
        undo.callback(tab.close)
        tab.goto(url)
        tab.wait_for_selector("body:not(.stale)")
        streams = [Stream(url, stream) for stream in range(STREAMS)]
        for stream in streams:
            undo.callback(stream.close)
            stream.start()
        yield page
        assert all(stream.bytes > 10_000 for stream in streams), "a stream is silent"


def block(hardware: Hardware, client: Driven, notes: Tail, cycles: int) -> Latencies | None:
    """Grip and drop, and return the latencies; None if a stalled machine made a cycle fail."""
    client.tell(f"cycles {cycles}")
    failed = client.wait_done(expected_s=cycles * CYCLE_S, timeout_s=cycles * LONGEST_S)
    new = notes.new()
    try:
        if failed:
            raise MatchError(" ".join(failed))
        lines = [actuator.line for _, actuator in hardware.description.ordered]
        return product_latencies(read(hardware.saw), new, lines)
    except MatchError as error:
        print(f"left out: {error}", file=sys.stderr)
        return None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=10)
    parser.add_argument("--cycles", type=int, default=6, help="grips and drops in a block")
    parser.add_argument("--browser", default="/usr/bin/chromium")
    arguments = parser.parse_args()
    from playwright.sync_api import sync_playwright

    pairs: list[tuple[Latencies, Latencies]] = []
    used: list[float] = []
    with tempfile.TemporaryDirectory() as made, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=arguments.browser, args=["--no-sandbox"])
        folder = Path(made)
        with Hardware(load(profile_path()), folder) as hardware:
            notes = folder / "states.jsonl"
            client = Driven(
                hardware.children, "latency/_tool_client.py", [hardware.description_path, notes], folder
            )
            client.wait_ready()
            tail = Tail(notes)
            block(hardware, client, tail, 1)  # whatever is slow the first time
            for number in range(arguments.pairs):
                found: dict[bool, Latencies | None] = {}
                for seen in (False, True) if number % 2 == 0 else (True, False):
                    if not seen:
                        found[seen] = block(hardware, client, tail, arguments.cycles)
                        continue
                    with watched(hardware, browser, number) as page:
                        meter = Meter({"page": page.pid})
                        found[seen] = block(hardware, client, tail, arguments.cycles)
                        used.append(meter.read()["page"].cpu_percent)
                alone, with_watchers = found[False], found[True]
                if alone is not None and with_watchers is not None:
                    pairs.append((alone, with_watchers))
                print(f"pair {number + 1} of {arguments.pairs}", file=sys.stderr)
        browser.close()
    found_ms: dict[str, Any] = {"pairs": len(pairs), "page_cpu_percent": round(median(used), 1)}
    costs: dict[str, float] = {}
    for name in ("reaction", "command"):
        ratios = sorted(median(seen[name]) / median(alone[name]) for alone, seen in pairs)
        costs[name] = 100 * (median(ratios) - 1)
        found_ms[name] = {
            "alone_us": median(sample for alone, _ in pairs for sample in alone[name]),
            "watched_us": median(sample for _, seen in pairs for sample in seen[name]),
            "costs_percent": round(costs[name], 1),
            "ratios": [round(ratio, 2) for ratio in ratios],
        }
    print(json.dumps(found_ms, indent=1))
    cheap, light = costs["reaction"] < COSTS_PERCENT, median(used) < PAGE_PERCENT
    print(
        f"{'met   ' if cheap else 'MISSED'} the reaction costs less than 5 % more: {costs['reaction']:.1f} %"
    )
    print(f"{'met   ' if light else 'MISSED'} the page takes less than 15 % of a core: {median(used):.1f} %")
    return int(not (cheap and light))


if __name__ == "__main__":
    sys.exit(main())
