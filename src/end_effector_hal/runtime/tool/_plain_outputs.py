"""The plain outputs of a tool: switched on request, and left as declared when their process ends."""

from __future__ import annotations

import logging
from collections.abc import Mapping

from end_effector_hal._closing import Closing
from end_effector_hal.arbiter import OUTPUTS, connect_arbiter
from end_effector_hal.control import Answer
from end_effector_hal.description import Description
from end_effector_hal.errors import ArbiterError, WireError
from end_effector_hal.vocabulary import LastWill, LastWillStep, display_name

_log = logging.getLogger("end_effector_hal.runtime")


class PlainOutputs(Closing):
    """A separate client of the line arbiter, so that plain outputs and their end affect no grip; thread-safe.

    Args:
        description: the tool; without `outputs` no client is connected.

    Raises:
        ArbiterError: there is no line arbiter.
        LineBusyError: another process switches the plain outputs.
    """

    def __init__(self, description: Description) -> None:
        self._outputs = description.outputs
        self._client = connect_arbiter(description, OUTPUTS) if self._outputs else None
        if self._client is not None and (will := self._will):
            self._client.set({}, will)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all plain outputs."""
        return tuple(self._outputs)

    @property
    def levels(self) -> Mapping[str, bool]:
        """Whether each plain output is active, as the line arbiter reads them back; raises ArbiterError.

        One on a bus is left out while its level is unknown.
        """
        levels = self._client.levels() if self._client else {}
        return {name: levels[each.line] for name, each in self._outputs.items() if each.line in levels}

    def set(self, name: str, active: bool) -> Answer:
        """Switch a plain output; raises KeyError for an unknown name.

        A success means only that its line was written, or that its device is commanded: no sensor proves it.
        """
        output = self._outputs[name]
        assert self._client is not None
        try:
            self._client.set({output.line: active})
        except WireError as error:
            return Answer(False, str(error), decided=not isinstance(error, ArbiterError))
        told = f"is {'commanded ' if output.modbus else ''}{'on' if active else 'off'}"
        return Answer(True, f"{display_name(name)} {told}; no sensor proves it.")

    def close(self) -> None:
        """Close the connection; the line arbiter does what `on_death` declares."""
        if self._client is None:
            return
        try:
            self._client.close(self._will)
        except WireError as error:
            _log.warning(
                "the line arbiter cannot be reached to leave the plain outputs as declared: %s", error
            )

    @property
    def _will(self) -> LastWill:
        return tuple(
            LastWillStep(each.line) for each in self._outputs.values() if each.on_death == "deactivate"
        )
