"""An SROS 2 policy, read back: what it allows on the graph. Its form is that of ``policy.xsd`` 0.2.0 of SROS 2."""

from __future__ import annotations

import importlib.util
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterable
from typing import Any

from end_effector_hal.nodes.interface import ACTIONS

RIGHTS = {
    "topics": ("topic", {"publish", "subscribe"}),
    "services": ("service", {"reply", "request"}),
    "actions": ("action", {"call", "execute"}),
}
SERVICES_OF_ACTION = ("cancel_goal", "get_result", "send_goal")
TOPICS_OF_ACTION = ("feedback", "status")

NOT_SERVED = tuple(
    f"/{action.name}/"
    for action in ACTIONS
    if action.optional and importlib.util.find_spec(action.type.partition("/")[0]) is None
)


class Allowed(defaultdict[str, set[str]]):
    """Of one process: right, and the full names of topics and services."""

    def __init__(self) -> None:
        super().__init__(set)

    def served(self) -> Allowed:
        """Without what is not offered in this environment."""
        found = Allowed()
        for right, names in self.items():
            found[right] = {name for name in names if not name.startswith(NOT_SERVED)}
        return found


def on_graph(node: Any, names: Iterable[str]) -> Allowed:
    """What some nodes of one process do, as a node of rclpy sees it."""
    questions = {
        "publish": node.get_publisher_names_and_types_by_node,
        "subscribe": node.get_subscriber_names_and_types_by_node,
        "reply": node.get_service_names_and_types_by_node,
        "request": node.get_client_names_and_types_by_node,
    }
    found = Allowed()
    for name in names:
        for right, ask in questions.items():
            if entities := {entity for entity, _ in ask(name, "/")}:
                found[right] |= entities
    return found


def read_policy(text: str) -> dict[str, Allowed]:
    """Enclave, and what it may; asserts the form on the way."""
    policy = ET.fromstring(text)
    assert (policy.tag, policy.attrib) == ("policy", {"version": "0.2.0"})
    (enclaves,) = policy
    assert enclaves.tag == "enclaves"
    found: dict[str, Allowed] = {}
    for enclave in enclaves:
        assert (enclave.tag, set(enclave.attrib)) == ("enclave", {"path"})
        (profiles,) = enclave
        assert (profiles.tag, profiles.attrib) == ("profiles", {})
        assert enclave.attrib["path"] not in found
        allowed = Allowed()
        for profile in profiles:
            assert (profile.tag, set(profile.attrib)) == ("profile", {"ns", "node"})
            _read_profile(profile, allowed)
        found[enclave.attrib["path"]] = allowed
    return found


def _read_profile(profile: ET.Element, allowed: Allowed) -> None:
    space, node = profile.attrib["ns"].rstrip("/"), profile.attrib["node"]
    assert len(profile)
    for listed in profile:
        element, rights = RIGHTS[listed.tag]
        assert rights > set(listed.attrib) > set()
        assert set(listed.attrib.values()) == {"ALLOW"}
        assert len(listed)
        for each in listed:
            assert each.tag == element
            name = each.text or ""
            full = (
                name
                if name[0] == "/"
                else f"{space}/{node}{name[1:]}"
                if name[0] == "~"
                else f"{space}/{name}"
            )
            for right in listed.attrib:
                _allow(allowed, right, full)


def _allow(allowed: Allowed, right: str, name: str) -> None:
    """An action is services and topics, as SROS 2 takes it apart."""
    if right in ("call", "execute"):
        service, topic = ("request", "subscribe") if right == "call" else ("reply", "publish")
        allowed[service] |= {f"{name}/_action/{each}" for each in SERVICES_OF_ACTION}
        allowed[topic] |= {f"{name}/_action/{each}" for each in TOPICS_OF_ACTION}
    else:
        allowed[right].add(name)
