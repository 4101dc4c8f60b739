"""The basis of every stanza: a frozen base class and the types of its values.

Pressures are gauge kPa; a vacuum is given as kPa *below* ambient, a positive number. Times are seconds unless the key
contains another unit.
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, SerializerFunctionWrapHandler, model_serializer

Seconds = Annotated[float, Field(ge=0.001, le=600)]
MaybeSeconds = Annotated[float | None, Field(ge=0.001, le=600)]
Kilopascal = Annotated[float, Field(gt=0, le=2000)]
MaybeMillimetres = Annotated[float | None, Field(gt=0, le=5000)]
BelowAmbient = Annotated[float, Field(gt=0, le=100)]
Samples = Annotated[int, Field(ge=1, le=1000)]
Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$", max_length=40)]
RosName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*$", max_length=80)]
PRINTABLE = r"^[^\x00-\x1f\x7f-\x9f\u2028\u2029]*$"
Word = Annotated[str, Field(pattern=PRINTABLE)]
"""Text on one line."""
NO_CHANNEL = "none"
"""Value of a channel key for a missing sensor: what it would prove is off, and is reported as off."""
Settling = Annotated[int, Field(ge=0, le=10_000)]
"""Time for which a switch must not change, ms."""

# A YAML sequence is a list; frozen objects hold tuples.
Names = Annotated[tuple[Name, ...], Field(strict=False)]
Texts = Annotated[tuple[str, ...], Field(strict=False)]


def named(channel: str | None) -> str | None:
    """Return the channel that a key names; None: there is no such sensor."""
    return None if channel == NO_CHANNEL else channel


class BaseStanza(BaseModel):
    """One stanza of a description.

    pydantic builds what reads a stanza at its first use, not at each start; therefore the default of a key that holds
    a stanza is made with ``model_construct()``, which needs none of it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, defer_build=True)

    @model_serializer(mode="wrap")
    def _written(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Return every key that has a value, defaults included.

        An absent stanza stays absent, because ``link: null`` does not mean a link.
        """
        content: dict[str, Any] = dump(self)
        for key, field in type(self).model_fields.items():
            if field.default in (None, {}) and getattr(self, key) == field.default:
                content.pop(key, None)
                content.pop(field.alias or key, None)
        for key in self.superseded():
            content.pop(key, None)
        return content

    def superseded(self) -> tuple[str, ...]:
        """Return the keys that another key replaces; they are not written, not even with their defaults."""
        return ()
