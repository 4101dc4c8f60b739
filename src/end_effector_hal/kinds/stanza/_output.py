"""The stanza of an output: a line of the board, or registers on a bus; all above the wires knows only its name."""

from __future__ import annotations

from typing import Any

from pydantic import Field, model_validator

from ._base import BaseStanza, Word
from ._line import LineName
from ._registers import RegisterOutput, with_line


class Output(BaseStanza):
    """An output: a `line` of the board, or a coil, a bit or registers of a Modbus device (`modbus`)."""

    line: LineName = Field(
        description="name of the GPIO line, as gpioinfo shows it; required without `modbus`"
    )
    pin: Word = Field(default="", description="where it is found on the board; for people")
    modbus: RegisterOutput | None = Field(
        default=None, description="instead of `line`: a coil or registers of a device on the link"
    )

    device: Word | None = Field(
        default=None,
        exclude=True,
        description="a device of the library that gives all keys which are not written here, and its channels; beside "
        "it `unit` is its address on the bus, `link` its link, if there are several, and `output` one of its outputs, "
        "if it has several. `eehal devices` lists them",
    )

    @model_validator(mode="before")
    @classmethod
    def _output_has_a_name(cls, given: Any) -> Any:
        return with_line(given)

    def superseded(self) -> tuple[str, ...]:
        """Return ``line`` if the output is in registers: its name is made from its address."""
        return ("line",) if self.modbus else ()
