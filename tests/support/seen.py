"""A run that was observed, as a process that asks for exactly it: a network has the run if its end can be reached."""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import escape

SeenStep = tuple[int, dict[str, str]]
"""A time in ms, and labels by kind; ``never``: receptions, separated by blanks, that must not come before this step."""
_KINDS = ("guard", "synchronisation", "assignment")


def seen(steps: Sequence[SeenStep]) -> str:
    """The template ``Seen``, whose location ``End`` is reached where the run is one of the network.

    A step that receives may come early: where that matters, a step without labels stands before it.
    """
    locations, edges = "", ""
    for number, (at, labels) in enumerate(steps):
        locations += f'<location id="s{number}"><label kind="invariant">z &lt;= {at}</label></location>'
        guard = "" if labels.get("synchronisation", "").endswith("?") else f"z >= {at}"
        texts = {**labels, "guard": " && ".join(filter(None, (guard, labels.get("guard", ""))))}
        edges += _edge(number, f"s{number + 1}", texts)
        for channel in labels.get("never", "").split():
            edges += _edge(number, "trap", {"synchronisation": channel})
    ends = f'<location id="s{len(steps)}"><name>End</name></location>'
    ends += '<location id="trap"><name>Trap</name><committed/></location>'  # nothing is searched beyond it
    head = "<template><name>Seen</name><declaration>clock z;</declaration>"
    return f'{head}{locations}{ends}<init ref="s0"/>{edges}</template>'


def _edge(source: int, target: str, texts: dict[str, str]) -> str:
    marks = "".join(
        f'<label kind="{kind}">{escape(texts[kind])}</label>' for kind in _KINDS if texts.get(kind)
    )
    return f'<transition><source ref="s{source}"/><target ref="{target}"/>{marks}</transition>'
