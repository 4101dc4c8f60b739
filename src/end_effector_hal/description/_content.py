"""The hash by which a recording or a proof names its tool."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from .model._description import Description


def content_hash(description: Description) -> str:
    """Return the hash of a tool and its automata, twelve hex digits; it does not depend on the tool's wiring."""
    content = description.model_dump(mode="json", by_alias=True)
    return hash_of(content, description.automata_path.read_bytes())


def hash_of(content: Mapping[str, Any], model: bytes) -> str:
    """Return the same hash from a description as JSON, with all defaults, and its UPPAAL file."""
    kept: dict[str, Any] = json.loads(json.dumps(content))
    kept.pop("lines", None)
    for link in (kept.get("link"), *(kept.get("links") or {}).values()):
        if link is not None:
            link.pop("port", None)
    if inputs := kept.get("inputs"):
        inputs.pop("iio", None)
    kept["automata"]["file"] = hashlib.sha256(model).hexdigest()
    order = ",".join(kept.get("parts") or {})  # the first part is the default one
    return hashlib.sha256((json.dumps(kept, sort_keys=True) + order).encode()).hexdigest()[:12]
