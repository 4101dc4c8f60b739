"""What every stanza is made of: a frozen base and the types of its values.

Pressures are gauge kPa; a vacuum is given as kPa *below* ambient, a positive number. Times are seconds unless
the key says otherwise.
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
"""Text in one line."""
NO_CHANNEL = "none"
"""Written where there is no such sensor: what it would prove is off, and said to be."""
Settling = Annotated[int, Field(ge=0, le=10_000)]
"""ms for which a switch must show the same."""
LineName = Annotated[str, Field(pattern=PRINTABLE, min_length=1, max_length=64)]

# A YAML sequence is a list; frozen objects hold tuples.
Names = Annotated[tuple[Name, ...], Field(strict=False)]
Texts = Annotated[tuple[str, ...], Field(strict=False)]


def named(channel: str | None) -> str | None:
    """A channel that a key names; None: there is no such sensor."""
    return None if channel == NO_CHANNEL else channel


class Part(BaseModel):
    """One stanza of a description."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    @model_serializer(mode="wrap")
    def _written(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Every key that has a value, defaults included; an absent stanza stays absent: ``link: null`` is no link."""
        content: dict[str, Any] = dump(self)
        for key, field in type(self).model_fields.items():
            if field.default in (None, {}) and getattr(self, key) == field.default:
                content.pop(key, None)
                content.pop(field.alias or key, None)
        for key in self.superseded():
            content.pop(key, None)
        return content

    def superseded(self) -> tuple[str, ...]:
        """Keys that another key replaces; they are not written, not even with their defaults."""
        return ()
