"""``python -m tools.first_picture FILE.svg``: the moving picture of the README, from a run of its ten lines."""

import re
from dataclasses import replace
from pathlib import Path
from subprocess import run as run_command
from tempfile import TemporaryDirectory

import click
from matplotlib.figure import Figure

from end_effector_hal.cli import PathName
from end_effector_hal.errors import UsageError
from end_effector_lab.figures import RecordedRun, save, timeline
from tools import run

README = Path(__file__).parent.parent / "README.md"
SCENARIO, WIDTH_IN = "leak:right:25", 9.4
AHEAD_S, SPEED, STILL_S = 1, 2.5, 5
"""Seconds of the whole picture before it moves, how much faster than real time it does, seconds until it repeats."""


def recorded(folder: Path) -> RecordedRun:
    """Grip with the README's tool, one cup of which leaks, and return the recording (in half a minute)."""
    (text,) = re.findall(r"^```yaml\n(.*?)^```", README.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    (folder / "tool.yaml").write_text(text, encoding="utf-8")
    words = ["--scenario", SCENARIO, "--script", "grip; quit", "--record", str(folder / "run")]
    # the grip fails, so the exit code is not 0; without a recording, `read` says so
    run_command(["eehal", "run", "--simulate", str(folder / "tool.yaml"), *words], check=False)
    return RecordedRun.read(folder / "run" / "states.csv")


def draw(recording: RecordedRun) -> Figure:
    """Draw the default figure, narrow enough for a README and without what differs from run to run."""
    info = replace(recording.info, started="", version="", hash="")
    return timeline(recording.log, recording.pressures, info, recording.alarms, width_in=WIDTH_IN)


def save_moving(figure: Figure, path: Path) -> None:
    """Save a timeline as an SVG whose curtain opens with time; a viewer without CSS animation shows the whole figure.

    A text appears as a whole when the time has passed its right end, and the verdict at the end.
    """
    axes = figure.axes
    area = axes[0].get_window_extent()
    foot = axes[-1].get_window_extent().y0
    start_s, end_s = axes[0].get_xlim()
    moving_s = (end_s - start_s) / SPEED
    whole_s = moving_s + STILL_S
    shown = {"verdict": 1.0}
    figure.texts[0].set_gid("verdict")
    for number, text in enumerate(text for each in axes for text in each.texts):
        box = text.get_window_extent()
        if area.x0 < box.x1 and box.x0 < area.x1:
            text.set_gid(f"text{number}")
            shown[f"text{number}"] = min((box.x1 - area.x0) / area.width, 1.0)
    save(figure, path)

    styles = [f".curtain{{animation:open {whole_s:.2f}s linear {AHEAD_S}s infinite}}"]
    width, height = area.width * 72 / figure.dpi, (area.y1 - foot) * 72 / figure.dpi
    opened = f"{100 * moving_s / whole_s:.2f}%"
    styles.append(
        f"@keyframes open{{0%{{opacity:1;transform:none}}{opened},to{{opacity:1;transform:translateX({width:.1f}px)}}}}"
    )
    for name, share in shown.items():
        at = 100 * share * moving_s / whole_s
        styles.append(f"#{name}{{animation:{name} {whole_s:.2f}s {AHEAD_S}s infinite}}")
        styles.append(f"@keyframes {name}{{0%,{at:.2f}%{{opacity:0}}{at + 0.01:.2f}%,to{{opacity:1}}}}")
    left, top = area.x0 * 72 / figure.dpi, figure.get_figheight() * 72 - area.y1 * 72 / figure.dpi
    box_words = f'x="{left + 1:.1f}" y="{top:.1f}" width="{width:.1f}" height="{height:.1f}"'
    curtain = (
        f"<style>@media(prefers-reduced-motion:no-preference){{{''.join(styles)}}}</style>"
        f'<clipPath id="area"><rect {box_words}/></clipPath><g clip-path="url(#area)"><g class="curtain" opacity="0">'
        f'<rect {box_words} fill="#fff"/><rect {box_words.replace(f"{width:.1f}", "1.5", 1)} fill="#1d2733"/></g></g>'
    )
    svg = path.read_text(encoding="utf-8").replace("'DejaVu Sans'", "'DejaVu Sans',Verdana,sans-serif")
    path.write_text(svg.replace("</svg>", f"{curtain}</svg>"), encoding="utf-8")


@click.command()
@click.argument("path", metavar="FILE.svg", type=PathName())
def command(path: Path) -> None:
    """Write the README's moving picture of a grip that fails."""
    if path.suffix != ".svg":
        raise UsageError(f"{path.name!r} is not .svg.", where=str(path))
    with TemporaryDirectory() as folder:
        save_moving(draw(recorded(Path(folder))), path)


if __name__ == "__main__":
    run(command)
