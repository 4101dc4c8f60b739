"""The shipped tool with other endings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.kinds.stanza import ChangerEndings, Endings, OwnEndings

Stanza = Mapping[str, Any]


def declared(
    whole: Stanza | None = None, *, changer: Stanza | None = None, il_09: bool = True, **own: Stanza
) -> Description:
    """With ``endings`` of the whole tool, of the tool changer, and of single actuators, by name."""
    shipped = load(profile_path())
    actuators = {
        name: actuator.model_copy(update={"endings": OwnEndings.model_validate(own.get(name, {}))})
        for name, actuator in shipped.actuators.items()
    }
    assert own.keys() <= actuators.keys()
    assert shipped.tool_changer
    endings = ChangerEndings.model_validate(changer or {})
    return shipped.model_copy(
        update={
            "endings": Endings.model_validate(whole or {}),
            "actuators": actuators,
            "tool_changer": shipped.tool_changer.model_copy(update={"endings": endings}),
            "interlocks": shipped.interlocks.model_copy(update={"il_09": il_09}),
        }
    )
