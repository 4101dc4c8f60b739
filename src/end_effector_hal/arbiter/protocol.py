"""Messages between the line arbiter and its clients: a JSON object per line, on a Unix stream socket.

Requests have ``op``, and an ``id`` (an integer or a short text) that the reply repeats::

    {"id": 1, "op": "hello", "client": "grip", "token": "5be0cd191f83d9ab9b05688c2b3e6c1f",
                           "lines": ["SODIMM_208"], "will": [], "faults": {}}
    {"id": 2, "op": "set", "until_us": 815000000, "levels": {"SODIMM_208": true},
                           "will": [{"line": "SODIMM_208", "level": false, "after_us": 0}]}
    {"id": 3, "op": "renew"}
    {"id": 4, "op": "levels"}
    {"id": 5, "op": "status"}
    {"id": 6, "op": "bye", "will": []}
    {"id": 7, "op": "latch", "fault": "sensor_fault", "why": "IL-04: both bits of the tool changer are set."}
    {"id": 8, "op": "reset"}
    {"id": 9, "op": "stop"}
    {"id": 10, "op": "clear", "fault": "sensor_fault"}

    {"id": 1, "op": "hello", "role": "sensors", "client": "pressure",
                           "token": "0d5f6c6e2b8a4f0d9b7e3a1c5d2f4b68"}
    {"op": "tell", "at_us": 815000000, "predicates": {"locked": true}}

**Writing lines.** ``hello`` names the lines that the client will write; each line has one writing client. ``token`` is
32 random hexadecimal digits (0 to f) that the client makes once. A client with the same name and token is the same
client, connecting again after a lost connection or a restart of the arbiter. A client with another token is another
program, and the last will of the earlier one is executed. A pid would not distinguish them: the arbiter sees pid 0 for
every client in a PID namespace of its own, as in a container. No reply contains a token. While the last will of the
earlier client is executed, ``hello`` is refused with the code EE-402 and ``retry_us``: a last will is finished first,
so that the next client adopts lines that do not change.

``set`` is atomic and leaves a last will (left out: the previous one stays valid); an empty last will holds. A step is
an object or ``["SODIMM_208", false, 0]``. Clients send id, op and time first, as above: the arbiter checks the rest of
a repeated ``set`` or ``tell`` only once. ``"drop": true`` means that a person asked for the deactivations: they are
written even where the line counts as inactive already, and a device on a bus may be acknowledged and activated first,
as described, unless an interlock refuses an activation now. ``"part": "panel"`` is the name of the part that is
gripped; the arbiter keeps it for the next program, which gets it in the reply to ``levels``. ``values`` has the
registers that make an output on a bus grip it, by line, where they depend on the part: ``{"modbus:9/0x03E8": [2304,
128, 65535]}``. After ``until_us`` (monotonic clock; left out: no limit) the whole ``set`` is refused, because its
sender has stopped waiting for it. ``renew`` renews the lease, and its reply has the latched ``faults``; ``set`` renews
the lease too.

``bye`` ends the session in order: its last will is executed at once, and the earlier last will is void. If the socket
is closed without ``bye``, or the lease expires, the client counts as dead, and its last will is executed. The last
step of a last will is due at most 10 s after the death, or later if the description of the tool needs that.

**Predicates.** Clients that write lines cannot report predicates. A ``hello`` with the role ``sensors`` gives that
role to its connection; one connection at a time has it. While that connection sends, another one is refused with
EE-402, and a fault is latched: another process claims to read the sensors. A connection with the token and the user
(SO_PEERCRED) of the first one counts as the first one. Once the first one was silent for 150 ms, another process of
the same user may get the role; a process of another user gets it only when the first connection has ended (the arbiter
closes a connection after 10 s of silence).

``tell`` is accepted only from the connection with this role. It is sent on every change and at least every 50 ms, and
reports the predicates that were proven at ``at_us`` (monotonic clock, never ahead of now). It names only predicates
that a line needs and that the arbiter does not prove by input lines of its own. A predicate is valid for 150 ms after
``at_us``. If the activation of a line needs a predicate (IL-01, IL-02, IL-05, IL-07, IL-13), it is refused without
that predicate; a missing predicate never deactivates a line. A ``tell`` without an ``id`` gets a reply only if it is
refused.

**Faults.** ``latch`` keeps a fault of a client that writes lines, by a name that the arbiter's policy lists, also
through a restart; ``status`` shows it, and it refuses nothing. ``clear`` ends it: the client sends ``clear`` after its
own reset. The policy names the client that shows a fault. That client may also clear the fault if it has not latched
it itself but finds it in ``status``, because the journal was read late. A ``hello`` has all faults that the client has
latched and not cleared; this list replaces earlier reports to another arbiter or over a lost connection (left out: the
faults of its last session). Faults that the arbiter latches itself for an interlock (IL-03, IL-13) have no limit that
a client could use up.

``reset`` clears all faults; it is refused with EE-403 for faults whose cause persists (an open e-stop). A fault of a
live client that has not cleared it also stays, no matter which client has latched it (restart a client that never
shows it); ``stays`` in the reply has a sentence for each, by name. ``stop`` latches what an open e-stop latches
(IL-13): until a reset, also through a restart, nothing is activated, and no line is changed. A program that finds this
fault cancels its running grip.

``levels``, ``status``, ``reset`` and ``stop`` need no ``hello``: they change no line and no lease, a reset clears only
faults whose cause is over, and a stop only refuses. A connection without ``hello`` is closed after 10 s without a
message, and the oldest of them when there are more than 32; connections that write lines or send predicates do not
count.

Replies: ``{"id", "ok", "error", "levels"}``; ``levels`` has all lines, true is active. For the request ``levels`` they
are read back: a line of unknown level is left out, unless it was last inactive. ``error`` is a sentence, with ``code``
(see `end_effector_hal.errors`); it begins with the id of the interlock that refuses. Further keys: ``stays`` of
``reset``, ``delay_us`` of ``set`` (time until it is applied, IL-10), ``retry_us``, ``overtaken`` of ``hello`` (the
client was declared dead before), ``status``. A reply with the id null belongs to no request: the arbiter ends the
connection and gives the reason.

Incoming content is limited, so that it is safe to repeat in replies and logs. Texts have printable characters only; a
name has at most 64, a sentence at most 500; numbers are integers of at most 18 digits. A message has at most 128 lines,
528 predicates and 262,144 bytes: enough for a tool of 64 actuators.
"""

from __future__ import annotations

import json
import re
import secrets
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeGuard, TypeVar

from pydantic_core import PydanticSerializationError, from_json, to_json

from end_effector_hal.errors import LineBusyError, UsageError
from end_effector_hal.vocabulary import (
    LONGEST_NAME,
    LONGEST_SENTENCE,
    MOST_LINES,
    MOST_PREDICATES,
    NO_PART,
    LastWill,
    WrittenPart,
    is_name,
    printable,
    read_last_will,
)

T = TypeVar("T")


def write_message(message: Mapping[str, object]) -> bytes:
    """Return compact JSON as a line."""
    try:
        return to_json(message) + b"\n"
    except PydanticSerializationError:  # half of a surrogate pair, as in the name of a file
        return json.dumps(message).encode() + b"\n"


def read_object(line: bytes) -> dict[str, Any]:
    """Parse a line into an object; its texts may have characters that are not printable. Raises UsageError."""
    try:
        message = from_json(line)
    except ValueError:  # perhaps half of a surrogate pair
        try:
            message = json.loads(line.decode())
        except (ValueError, RecursionError):
            message = None
    if not isinstance(message, dict):
        raise UsageError("a message must be a JSON object in UTF-8.")
    return message


def read_record(content: bytes, read: Callable[[Any], T]) -> T:
    """Return the result of ``read`` on the object of a record; raises UsageError if that lacks what it needs."""
    try:
        return read(read_object(content))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise UsageError(f"unexpected JSON: {error}.") from error


DEEPEST = 4
DIGITS = 18


def read_message(line: bytes) -> dict[str, Any]:
    """Parse a line into an object; its sentence ``why`` is made printable.

    Raises:
        UsageError: the line is not an object, or contains a number or a text that no message needs.
    """
    message = read_object(line)
    if isinstance(why := message.get("why"), str):
        message["why"] = printable(why)
    _check(message, DEEPEST)
    return message


def _check(message: dict[str, Any], deepest: int) -> None:
    level: list[Any] = [message]
    for _ in range(deepest):
        inside: list[Any] = []
        for value in level:
            inside += value
            if isinstance(value, dict):
                inside += value.values()
        level = []
        for value in inside:
            if isinstance(value, dict | list):
                level.append(value)
            elif isinstance(value, str) and not (len(value) <= LONGEST_SENTENCE and value.isprintable()):
                raise UsageError(
                    f"a text in a message may have at most {LONGEST_SENTENCE} characters, all printable."
                )
            elif isinstance(value, float) or (isinstance(value, int) and abs(value) >= 10**DIGITS):
                raise UsageError(f"a number in a message must be an integer of at most {DIGITS} digits.")
    if level:
        raise UsageError(f"a message may be nested at most {deepest} levels deep.")


class LastWillRunsError(LineBusyError):
    """The last will of the client that had these lines is still being executed.

    Args:
        what: one sentence.
        retry_us: time until the last will is finished, µs; send ``hello`` again after it.
    """

    def __init__(self, what: str, retry_us: int) -> None:
        super().__init__(what)
        self.retry_us = retry_us


MOST_REGISTERS = 16
"""Most values of one output in a ``set``."""
MOST_FAULTS = 16
"""Most faults in the ``hello`` of a client."""
_TOKEN = re.compile("[0-9a-f]{32}")


def make_token() -> str:
    """Return a new random token."""
    return secrets.token_hex(16)


def is_token(given: object) -> TypeGuard[str]:
    """Return whether the value is a text of 32 digits from 0 to f."""
    return isinstance(given, str) and _TOKEN.fullmatch(given) is not None


OPS = ("hello", "set", "renew", "levels", "status", "bye", "tell", "latch", "clear", "reset", "stop")
SENSORS = "sensors"


class Request(NamedTuple):
    """A well-formed request.

    ``time_us``: after it a ``set`` is refused (None: no limit); at it the predicates of a ``tell`` were proven.
    """

    op: str
    role: str = ""
    client: str = ""
    token: str = ""
    lines: tuple[str, ...] = ()
    levels: Mapping[str, bool] = {}
    will: LastWill | None = None
    time_us: int | None = None
    drop: bool = False
    part: WrittenPart = NO_PART
    predicates: Mapping[str, bool] = {}
    fault: str = ""
    why: str = ""
    faults: Mapping[str, str] | None = None


HEAD = re.compile(rb'\{(?:"id":(0|[1-9]\d{0,17}),)?("op":"(?:set","until|tell","at)_us":)(0|[1-9]\d{0,17}),')
"""Beginning of a ``set`` or ``tell`` as the clients here write it: its id, its kind and its time."""
_ODD = re.compile(rb'\\|"(?:id|op|until_us|at_us)"')
LONGEST_KEPT, MOST_KEPT = 16_384, 64
"""Longest message of which `read_rest` is cached, bytes, and the number of them."""


def read_rest(kind: bytes, rest: bytes) -> Request | None:
    """Return the request of a message by what follows its `HEAD`; None: the message must be read in full."""
    if _ODD.search(rest):
        return None
    try:
        return read_request(read_message(b"{%b0,%b" % (kind, rest)))
    except UsageError:
        return None


def read_id(message: Mapping[str, Any]) -> int | str | None:
    """Return the id that the reply repeats; None: the message has none.

    Raises:
        UsageError: the id is neither an integer nor a short text.
    """
    number = message.get("id")
    if number is None or type(number) is int or is_name(number):
        return number
    raise UsageError("id must be an integer or a text of at most 64 characters.")


def read_request(message: Mapping[str, Any]) -> Request:
    """Check every field and return the request.

    Raises:
        UsageError: a field is wrong; the message names it.
    """
    op = message.get("op")
    if op not in OPS:
        raise UsageError(f"op must be one of {', '.join(OPS)}.")
    read = _READERS.get(op)
    return read(message) if read else Request(op, will=_read_last_will(message))


def _read_last_will(message: Mapping[str, Any]) -> LastWill | None:
    will = message.get("will")
    return None if will is None else read_last_will(will)


def _read_hello(message: Mapping[str, Any]) -> Request:
    role, client, token = message.get("role", ""), message.get("client"), message.get("token")
    faults = message.get("faults")
    if role not in ("", SENSORS):
        raise UsageError(f"role must be left out, or {SENSORS}.")
    if not is_name(client):
        raise UsageError("client must be a name of at most 64 printable characters.")
    if not is_token(token):
        raise UsageError("token must be 32 random digits from 0 to f, the same in each hello of a client.")
    if role == SENSORS:
        return Request("hello", role, str(client), token)
    lines = message.get("lines")
    if not (isinstance(lines, list) and 0 < len(lines) <= MOST_LINES and all(map(is_name, lines))):
        raise UsageError(f"lines must be a list of 1 to {MOST_LINES} line names.")
    if faults is not None and not _is_sentences(faults):
        raise UsageError(f"faults must be an object of at most {MOST_FAULTS} sentences by name.")
    will = _read_last_will(message)
    return Request("hello", role, str(client), token, tuple(lines), will=will, faults=faults)


def _read_set(message: Mapping[str, Any]) -> Request:
    levels, until_us = message.get("levels", {}), message.get("until_us")
    drop, part, values = message.get("drop", False), message.get("part", ""), message.get("values", {})
    if not (_is_flags(levels, MOST_LINES) and (levels or "will" in message)):
        raise UsageError(f"levels must be an object of at most {MOST_LINES} line names, each true or false.")
    if until_us is not None and type(until_us) is not int:
        raise UsageError("until_us must be a time in µs.")
    if not isinstance(drop, bool):
        raise UsageError("drop must be true or false.")
    if part != "" and not is_name(part):
        raise UsageError("part must be a name of at most 64 printable characters.")
    if not (
        isinstance(values, dict) and len(values) <= MOST_LINES and all(map(_is_registers, values.values()))
    ):
        raise UsageError(
            f"values must be an object of 1 to {MOST_REGISTERS} numbers from 0 to 65535 by line."
        )
    grips = NO_PART
    if part or values:
        grips = WrittenPart(str(part), {line: tuple(each) for line, each in values.items()})
    will = _read_last_will(message)
    return Request("set", levels=levels, will=will, time_us=until_us, drop=drop, part=grips)


def _is_registers(given: object) -> bool:
    return (
        isinstance(given, list)
        and 0 < len(given) <= MOST_REGISTERS
        and all(type(each) is int and 0 <= each <= 0xFFFF for each in given)
    )


def _read_predicates(message: Mapping[str, Any]) -> Request:
    predicates, at_us = message.get("predicates"), message.get("at_us")
    if not (predicates and _is_flags(predicates, MOST_PREDICATES)):
        raise UsageError(f"predicates must be an object of 1 to {MOST_PREDICATES} names, each true or false.")
    if type(at_us) is not int:
        raise UsageError("at_us must be a time in µs.")
    return Request("tell", predicates=predicates, time_us=at_us)


def _read_fault(message: Mapping[str, Any]) -> Request:
    op, fault, why = message["op"], message.get("fault"), message.get("why", "")
    if op == "latch" and not (isinstance(why, str) and why):
        raise UsageError("why must be a sentence.")
    if not is_name(fault):
        raise UsageError("fault must be a name of at most 64 printable characters.")
    return Request(op, fault=str(fault), why=why)


def _is_sentences(given: object) -> TypeGuard[dict[str, str]]:
    return (
        isinstance(given, dict)
        and len(given) <= MOST_FAULTS
        and all(is_name(name) and isinstance(why, str) and why for name, why in given.items())
    )


def _is_flags(given: object, most: int) -> bool:
    """Return whether the value is an object of at most ``most`` names, each true or false.

    `read_message` has checked that its texts are printable.
    """
    if not (isinstance(given, dict) and len(given) <= most):
        return False
    longest = max(map(len, given), default=0)
    return longest <= LONGEST_NAME and "" not in given and {*map(type, given.values())} <= {bool}


_READERS = {
    "hello": _read_hello, "set": _read_set, "tell": _read_predicates, "latch": _read_fault, "clear": _read_fault,
}  # fmt: skip
