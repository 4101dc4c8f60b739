"""Messages as lines of JSON: records, requests and answers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, NamedTuple, TypeVar, cast

from pydantic import Field, TypeAdapter, ValidationError
from pydantic_core import to_json

from end_effector_hal.errors import UsageError
from end_effector_hal.wires._clock import now_us

T = TypeVar("T")
VALID_US = 2_000_000
"""Latest value of ``until_us`` in a request, µs from now."""


@dataclass(frozen=True, slots=True)
class RpcRequest:
    """The fields of every request; each table of messages adds its own."""

    id: Annotated[int, Field(ge=0, le=2**53)]
    until_us: Annotated[int, Field(ge=0, le=2**62)]


class Reply(NamedTuple):
    """Whether a request was accepted, and why not.

    Attributes:
        decided: False: it may have been executed nevertheless.
        record: number of the first record that is certain to follow its execution, where records are numbered.
    """

    accepted: bool
    reason: str = ""
    decided: bool = True
    record: int = 0


@cache
def adapter_of(message: type[Any]) -> TypeAdapter[Any]:
    """Return the validator of a message type."""
    return TypeAdapter(message)


def read_message(message: type[T], line: bytes, what: str) -> T:
    """Read a line as a message of this type.

    Raises:
        UsageError: it is not a valid one; the message contains ``what`` and the wrong field.
    """
    try:
        found: T = adapter_of(cast("Any", message)).validate_json(line, strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"])) or "message"
        raise UsageError(f"This is not a valid {what}: {place}: {first['msg']}.") from None
    return found


def record_line(kind: str, at: int, content: object) -> bytes:
    """Return a record as a line."""
    return to_json({"kind": kind, "at": at, "content": content}, fallback=_plain) + b"\n"


def request_line(number: int, valid_us: int, fields: Mapping[str, object]) -> bytes:
    """Return a request as a line; it may be executed within ``valid_us`` from now."""
    return to_json({"id": number, **fields, "until_us": now_us() + valid_us}) + b"\n"


def answer_line(number: int | None, reply: Reply) -> bytes:
    """Return an answer as a line; ``number`` None: it belongs to no request."""
    return to_json({"kind": "answer-to", "id": number, **reply._asdict()}) + b"\n"


def read_answer(message: Mapping[str, Any]) -> tuple[int | None, Reply] | None:
    """Return number and content of an answer; None: it is a record. Raises KeyError for any other message."""
    if message["kind"] != "answer-to":
        return None
    accepted, decided = message["accepted"] is True, message["decided"] is True
    return message["id"], Reply(accepted, str(message["reason"]), decided, int(message["record"]))


def refuse_late(until_us: int) -> str:
    """Return why a request with this ``until_us`` must not be executed now; empty: it may be executed."""
    at = now_us()
    if at > until_us:
        return "The request came too late and was not executed."
    if until_us > at + VALID_US:
        return f"The request was not executed: until_us is more than {VALID_US // 1_000_000} s ahead. Check the clock."
    return ""


def _plain(value: object) -> object:
    return dict(value) if isinstance(value, Mapping) else str(value)
