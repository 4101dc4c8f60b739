"""The ROS interface, from the table that the nodes work with, and the messages as they are defined."""

from __future__ import annotations

from collections.abc import Iterator

from end_effector_hal.description import load, profile_path
from end_effector_hal.nodes.interface import ACTIONS, PARAMETERS, Service, Topic, services, topics

from ._markdown import ROOT, plain, table

PACKAGE = ROOT / "ros" / "end_effector_msgs"


def entries() -> str:
    """Topics, services, actions and parameters of the shipped tool."""
    tool = load(profile_path())
    return "\n\n".join((*_topics(topics(tool)), *_services(services(tool)), *_actions(), *_parameters()))


def _topics(found: tuple[Topic, ...]) -> Iterator[str]:
    yield "## Topics"
    yield table(
        ("name", "type", "publishers", "subscribers of the HAL", "when", "new subscribers get the last", "queue"),
        (
            (
                f"`{each.name}`", _type(each.type), ", ".join(each.publishers), ", ".join(each.subscribers),
                _when(each), "yes" if each.latched else "no", str(each.queue),
            )
            for each in found
        ),
    )  # fmt: skip


def _when(topic: Topic) -> str:
    on = {"change": "on each change", "frame": "with each frame", "command": "with each command"}.get(
        topic.on
    )
    rate = f"at {topic.rate_hz:g} Hz" if topic.rate_hz else ""
    return " and ".join(each for each in (on, rate) if each)


def _services(found: tuple[Service, ...]) -> Iterator[str]:
    yield "## Services"
    yield table(
        ("name", "type", "node"),
        ((f"`{each.name}`", _type(each.type), each.server) for each in found),
    )


def _actions() -> Iterator[str]:
    yield "## Actions"
    yield table(
        ("name", "type", "node", "ROS"),
        (
            (
                f"`{each.name}`", _type(each.type), each.server,
                " and ".join(map(str, each.generations)) + (", where its type is installed" if each.optional else ""),
            )
            for each in ACTIONS
        ),
    )  # fmt: skip


def _parameters() -> Iterator[str]:
    yield "## Parameters"
    yield "Private parameters (`~name`). A number or a boolean is given as it is or as text."
    yield table(
        ("name", "nodes", "meaning"),
        ((f"`{each.name}`", ", ".join(each.nodes), plain(each.about)) for each in PARAMETERS),
    )


def _type(name: str) -> str:
    package, _, own = name.partition("/")
    return f"[`{own}`](messages.md#{own.lower()})" if package == PACKAGE.name else f"`{name}`"


def messages() -> str:
    """Every message, service and action of ``end_effector_msgs``, word for word."""
    paths = [path for kind in ("action", "msg", "srv") for path in sorted((PACKAGE / kind).glob("*.*"))]
    return "\n\n".join(
        f"## {path.stem}\n\n`{path.relative_to(PACKAGE)}`\n\n```text\n{path.read_text(encoding='utf-8').strip()}\n```"
        for path in paths
    )
