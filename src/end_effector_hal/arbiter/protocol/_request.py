r"""Messages between the line owner and its clients: a JSON object per line, on a Unix stream socket.

Requests have ``op``, and an ``id`` (an integer or a short text) that the reply repeats::

    {"id": 1, "op": "hello", "client": "grip", "token": "5be0cd191f83d9ab9b05688c2b3e6c1f",
                           "lines": ["SODIMM_208"], "will": []}
    {"id": 2, "op": "set", "levels": {"SODIMM_208": true},
                           "will": [{"line": "SODIMM_208", "level": false, "after_us": 0}],
                           "until_us": 815000000}
    {"id": 3, "op": "renew"}
    {"id": 4, "op": "levels"}
    {"id": 5, "op": "status"}
    {"id": 6, "op": "bye", "will": []}
    {"id": 7, "op": "latch", "fault": "sensor_fault", "why": "IL-04: both bits of the tool changer are set."}
    {"id": 8, "op": "reset"}

    {"id": 1, "op": "hello", "role": "sensors", "client": "pressure", "token": "0d5f6c6e2b8a4f0d9b7e3a1c5d2f4b68"}
    {"op": "tell", "predicates": {"locked": true}, "at_us": 815000000}

**Writing lines.** ``hello`` names the lines that the client will write; each line has one writing client. ``token``
is 32 random digits from 0 to f, made once by the client: only one that says the same name and token again has come
back, after a lost connection or a restart of the owner; any other is another program, and the will of the one before
is executed. A pid would not tell them apart: in PID namespaces of their own, as in containers, all are pid 0 to the
owner. Tokens are shown to nobody. ``hello`` is answered with
the code EE-402 and ``retry_us`` while the will of the one before is executed: a will runs to its end first,
so that the next client adopts lines that stand still. ``set`` is atomic, and leaves a will (left out: the one
before stays valid); an empty will holds. After ``until_us`` (monotonic clock; left out: whenever it comes) it
is refused as a whole: its sender has given it up, and nobody knows of it any more. ``renew`` keeps the lease
and is answered with the latched ``faults``;
any ``set`` does, too. ``bye`` ends in order: the will in it is executed at once, the one left before is void.
A socket that is closed without it, or a lease that ends, is the death of the client: its will is executed.
The last step of a will is due at most 10 s after the death, or as late as the description of the tool needs it.

**Proving.** Who may ask for lines is not who may prove what the sensors show. A ``hello`` with the role ``sensors``
takes that role for its connection, of which there is one at a time. Another connection is refused with EE-402 while
the first one is heard, and a fault is latched: somebody else claims to read the sensors. It is the first one again
if it says its token and has its user (SO_PEERCRED). Once the first was silent for 150 ms another process of the same
user may take the role; one of another user only when the connection has ended, which the owner does after 10 s of
silence. ``tell`` counts only from there: on change and at least every 50 ms, what was proven at ``at_us`` (monotonic
clock, never ahead of now). It names predicates that a line needs, no others. It counts for 150 ms from then on. A
line whose activation needs a predicate (IL-01, IL-02, IL-05, IL-13) is refused without it; nothing is ever
deactivated for want of one. Without an ``id`` it gets no reply unless it is refused.

**Faults.** ``latch`` keeps a fault of a client that writes lines, by a name that the owner's policy lists, through a
restart; it shows in ``status`` and refuses nothing. What the owner latches itself for an interlock (IL-03, IL-13)
has no limit that a client could use up. ``reset`` clears all faults; it is refused with EE-403 for those that still
are the case (an open e-stop).

``levels``, ``status`` and ``reset`` need no hello: they change no line and no lease, and a reset clears only what is
over. Such a connection is closed after 10 s without a message, and the oldest of them when there are more than 32:
those that write lines or prove have their own room.

Replies: ``{"id", "ok", "error", "levels"}``, levels of all lines, active is true. ``error`` is a sentence,
with ``code`` (see `end_effector_hal.errors`); it begins with the id of the interlock that refuses. Further
keys: ``delay_us`` of ``set`` (until it is applied, IL-10), ``retry_us``, ``status``. A reply with the id null
belongs to no request: the owner ends the connection and says why.

Every text has printable characters only, a name at most 64, a sentence at most 500; numbers are integers of at most
18 digits; a message has at most 65,536 bytes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from end_effector_hal.arbiter.protocol._token import is_token
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import LastWill, is_name, read_last_will

MOST_NAMES = 64
"""Lines or predicates in one message."""
OPS = ("hello", "set", "renew", "levels", "status", "bye", "tell", "latch", "reset")
SENSORS = "sensors"


class Request(NamedTuple):
    """A request that is well formed."""

    op: str
    role: str = ""
    client: str = ""
    token: str = ""
    lines: tuple[str, ...] = ()
    levels: Mapping[str, bool] = {}
    will: LastWill | None = None
    until_us: int | None = None
    predicates: Mapping[str, bool] = {}
    at_us: int = 0
    fault: str = ""
    why: str = ""


def read_id(message: Mapping[str, Any]) -> int | str | None:
    """What the reply must repeat; None: there is none.

    Raises:
        UsageError: it is neither an integer nor a short text.
    """
    number = message.get("id")
    if number is None or type(number) is int or is_name(number):
        return number
    raise UsageError("id is an integer or a text of at most 64 characters.")


def read_request(message: Mapping[str, Any]) -> Request:
    """Checks every field.

    Raises:
        UsageError: says which one is wrong.
    """
    op = message.get("op")
    if op not in OPS:
        raise UsageError(f"op is one of {', '.join(OPS)}.")
    reader = {"hello": _read_hello, "set": _read_set, "tell": _read_tell, "latch": _read_latch}.get(op)
    return reader(message) if reader else Request(op, will=_read_will(message))


def _read_hello(message: Mapping[str, Any]) -> Request:
    role, client, token = message.get("role", ""), message.get("client"), message.get("token")
    if role not in ("", SENSORS):
        raise UsageError(f"role is left out, or {SENSORS}.")
    if not is_name(client):
        raise UsageError("client is a name of at most 64 printable characters.")
    if not is_token(token):
        raise UsageError("token is 32 random digits from 0 to f, the same in each hello of a client.")
    if role == SENSORS:
        return Request("hello", role, str(client), token)
    lines = message.get("lines")
    if not (isinstance(lines, list) and 0 < len(lines) <= MOST_NAMES and all(map(is_name, lines))):
        raise UsageError(f"lines is a list of 1 to {MOST_NAMES} line names.")
    return Request("hello", role, str(client), token, tuple(lines), will=_read_will(message))


def _read_set(message: Mapping[str, Any]) -> Request:
    levels, until_us = message.get("levels", {}), message.get("until_us")
    if not (_is_flags(levels) and (levels or "will" in message)):
        raise UsageError(f"levels is an object of at most {MOST_NAMES} line names, each true or false.")
    if until_us is not None and type(until_us) is not int:
        raise UsageError("until_us is a time in µs.")
    return Request("set", levels=levels, will=_read_will(message), until_us=until_us)


def _read_tell(message: Mapping[str, Any]) -> Request:
    predicates, at_us = message.get("predicates"), message.get("at_us")
    if not (predicates and _is_flags(predicates)):
        raise UsageError(f"predicates is an object of 1 to {MOST_NAMES} names, each true or false.")
    if type(at_us) is not int:
        raise UsageError("at_us is a time in µs.")
    return Request("tell", predicates=predicates, at_us=at_us)


def _read_latch(message: Mapping[str, Any]) -> Request:
    fault, why = message.get("fault"), message.get("why")
    if not is_name(fault):
        raise UsageError("fault is a name of at most 64 printable characters.")
    if not (isinstance(why, str) and why):
        raise UsageError("why is a sentence.")
    return Request("latch", fault=str(fault), why=why)


def _read_will(message: Mapping[str, Any]) -> LastWill | None:
    return None if message.get("will") is None else read_last_will(message["will"])


def _is_flags(given: object) -> bool:
    """Whether it is an object of names, each true or false."""
    return (
        isinstance(given, dict)
        and len(given) <= MOST_NAMES
        and all(is_name(name) and isinstance(value, bool) for name, value in given.items())
    )
