"""A policy of SROS 2, read back: what it allows on the graph. Its form is that of ``policy.xsd`` 0.2.0 of SROS 2."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import defaultdict

RIGHTS = {
    "topics": ("topic", {"publish", "subscribe"}),
    "services": ("service", {"reply", "request"}),
    "actions": ("action", {"call", "execute"}),
}
SERVICES_OF_ACTION = ("cancel_goal", "get_result", "send_goal")
TOPICS_OF_ACTION = ("feedback", "status")

Allowed = dict[str, set[str]]
"""Of one process: right, and the full names of topics and services."""


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
        allowed: Allowed = defaultdict(set)
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
