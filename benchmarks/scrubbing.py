"""Measures half an hour of a 50 Hz recording: read, written as one file, scrubbed in Chromium.

Run by hand, from the folder of the project: ``python -m benchmarks.scrubbing``.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

from end_effector_hal.page.recorded import RecordingFiles, judge_recording, read_recording
from end_effector_lab.recorded import report_html
from tests.support.recorded_tool import RecordedTool

AIM_MS = 100
MOMENTS = 300
# each moment is taken when the browser has painted the one before it; the second frame shows that it was painted
SCRUB = """async ([moments, span]) => {
  const scrub = document.getElementById("scrub");
  if (span) document.querySelector(`[data-span="${span}"]`).click();
  const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));
  const took = [];
  for (let number = 0; number < moments; number += 1) {
    await frame();
    const from = performance.now();
    scrub.value = scrub.max * (((number * 7919) % moments) / moments);
    scrub.dispatchEvent(new Event("input"));
    await frame();
    await new Promise((resolve) => setTimeout(resolve, 0));
    took.push(performance.now() - from);
  }
  return took.sort((a, b) => a - b);
}"""


def record(folder: Path, minutes: float) -> None:
    """Record grips of 40 s with a failing attempt in the first, and 20 s between them."""
    tool = RecordedTool(folder, "fails-once:cylinder")
    tool.run(2)
    while tool.at < minutes * 60e6:
        for word, seconds in (("grip", 40), ("drop", 20)):
            tool.command(word)
            tool.run(seconds)
    tool.close()


def scrub(report: Path, browser: str, viewport: dict[str, int]) -> dict[str, Any]:
    """Measure the time from a move of the slider until the moment is displayed, ms."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=browser, args=["--no-sandbox"])
        page = chromium.new_context(viewport=viewport).new_page()
        begun = time.monotonic()
        page.goto(f"file://{report}")
        page.wait_for_selector("body:not(.stale)")
        found: dict[str, Any] = {"opened_s": round(time.monotonic() - begun, 2)}
        for name, span in (("one minute", "60"), ("all", "NaN")):
            took = page.evaluate(SCRUB, [MOMENTS, span])
            found[name] = {
                "median_ms": round(took[len(took) // 2], 1),
                "p99_ms": round(took[round(len(took) * 0.99) - 1], 1),
                "worst_ms": round(took[-1], 1),
            }
        chromium.close()
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--browser", default="/usr/bin/chromium")
    parser.add_argument("--recording", type=Path, help="one that is there already")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        folder = arguments.recording or Path(made) / "run"
        if arguments.recording is None:
            record(folder, arguments.minutes)
        times = [time.process_time()]
        files = RecordingFiles(folder)
        times.append(time.process_time())
        content = read_recording(files).document
        times.append(time.process_time())
        verdict = judge_recording(files)
        times.append(time.process_time())
        report = Path(made) / "report.html"
        report.write_text(report_html(files.name, [content], [verdict]))
        opened, folded, judged = (after - before for before, after in pairwise(times))
        found = {
            "minutes": round((files.end - files.begin) / 60e6, 1),
            "recording_mb": round(sum(path.stat().st_size for path in files.paths) / 1e6, 1),
            "report_mb": round(report.stat().st_size / 1e6, 2),
            "moments": len(content["times"]),
            "cpu_s": {"open": round(opened, 1), "fold": round(folded, 1), "judge": round(judged, 1)},
            "desktop": scrub(report, arguments.browser, {"width": 1440, "height": 900}),
            "phone": scrub(report, arguments.browser, {"width": 390, "height": 844}),
        }
    print(json.dumps(found, indent=1))
    worst = max(found[who][what]["p99_ms"] for who in ("desktop", "phone") for what in ("one minute", "all"))
    print(f"{'met   ' if worst <= AIM_MS else 'MISSED'} 99 of 100 moments within {AIM_MS} ms: {worst} ms")
    return int(worst > AIM_MS)


if __name__ == "__main__":
    sys.exit(main())
