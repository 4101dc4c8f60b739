r"""Messages between the line owner and its clients: a JSON object per line, on a Unix stream socket.

Requests have ``op``, and an ``id`` that the reply repeats::

    {"id": 1, "op": "hello", "client": "grip", "token": "5be0cd191f83d9ab9b05688c2b3e6c1f",
                           "lines": ["SODIMM_208"], "will": []}
    {"id": 2, "op": "set", "levels": {"SODIMM_208": true},
                           "will": [{"line": "SODIMM_208", "level": false, "after_us": 0}],
                           "until_us": 815000000}
    {"id": 3, "op": "renew"}
    {"id": 4, "op": "levels"}
    {"id": 5, "op": "status"}
    {"id": 6, "op": "bye", "will": []}
    {"op": "tell", "predicates": {"locked": true}, "at_us": 815000000}
    {"id": 7, "op": "latch", "fault": "sensor_fault", "why": "IL-04: both bits of the tool changer are set."}
    {"id": 8, "op": "reset"}

``hello`` names the lines that the client will write; each line has one writing client. ``token`` is 32 random
digits from 0 to f, made once by the client: only one that says the same name and token again has come back, after
a lost connection or a restart of the owner; any other is another program, and the will of the one before is
executed. A pid would not tell them apart: in PID namespaces of their own, as in containers, all are pid 0 to the
owner. Tokens are shown to nobody. ``hello`` is answered with
the code EE-402 and ``retry_us`` while the will of the one before is executed: a will runs to its end first,
so that the next client adopts lines that stand still. ``set`` is atomic, and leaves a will (left out: the one
before stays valid); an empty will holds. After ``until_us`` (monotonic clock; left out: whenever it comes) it
is refused as a whole: its sender has given it up, and nobody knows of it any more. ``renew`` keeps the lease
and is answered with the latched ``faults``;
any ``set`` does, too. ``bye`` ends in order: the will in it is executed at once, the one left before is void.
A socket that is closed without it, or a lease that ends, is the death of the client: its will is executed.
``levels`` and ``status`` need no hello.

``tell`` comes from the process that reads the sensors, on change and at least every 50 ms: what they proved at
``at_us`` (monotonic clock). It counts for 150 ms from then on. A line whose activation needs a predicate (IL-01,
IL-02, IL-05, IL-13) is refused without it; nothing is ever deactivated for want of one. Without an ``id`` it gets no
reply. ``latch`` keeps a fault of a client by name through a restart; it shows in ``status`` and refuses nothing.
``reset`` clears all faults; it is refused with EE-403 for those that still are the case (an open e-stop).
These three need no hello, either.

Replies: ``{"id", "ok", "error", "levels"}``, levels of all lines, active is true. ``error`` is a sentence,
with ``code`` (see `end_effector_hal.errors`); it begins with the id of the interlock that refuses. Further
keys: ``delay_us`` of ``set`` (until it is applied, IL-10), ``retry_us``, ``status``. A reply with the id null
belongs to no request: the owner ends the connection and says why.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

from end_effector_hal.errors import UsageError
from end_effector_hal.wires.owner._token import is_token
from end_effector_hal.wires.will import Will, read_will

LONGEST = 1 << 16
MOST_PREDICATES = 32
OPS = ("hello", "set", "renew", "levels", "status", "bye", "tell", "latch", "reset")


class Request(NamedTuple):
    """A request that is well formed."""

    op: str
    id: int | str | None
    client: str = ""
    token: str = ""
    lines: tuple[str, ...] = ()
    levels: Mapping[str, bool] = {}
    will: Will | None = None
    until_us: int | None = None
    predicates: Mapping[str, bool] = {}
    at_us: int = 0
    fault: str = ""
    why: str = ""


def read_message(line: bytes) -> dict[str, Any]:
    """The object in a line.

    Raises:
        UsageError: it is none.
    """
    try:
        message = json.loads(line)
    except (ValueError, RecursionError):
        raise UsageError("this is no JSON object.") from None
    if not isinstance(message, dict):
        raise UsageError("this is no JSON object.")
    return message


def read_request(message: dict[str, Any]) -> Request:
    """Checks every field.

    Raises:
        UsageError: says which one is wrong.
    """
    op, number = message.get("op"), message.get("id")
    client, lines, levels = message.get("client", ""), message.get("lines", []), message.get("levels", {})
    token = message.get("token", "")
    if op not in OPS:
        raise UsageError(f"op is one of {', '.join(OPS)}.")
    if op == "hello" and not (isinstance(client, str) and 0 < len(client) <= 64):
        raise UsageError("client is a name of at most 64 letters.")
    if op == "hello" and not is_token(token):
        raise UsageError("token is 32 random digits from 0 to f, the same in each hello of a client.")
    if op == "hello" and not (isinstance(lines, list) and lines and all(isinstance(n, str) for n in lines)):
        raise UsageError("lines is a list of line names.")
    if op == "set" and not (
        isinstance(levels, dict)
        and (levels or "will" in message)
        and all(isinstance(level, bool) for level in levels.values())
    ):
        raise UsageError("levels is an object of line names, each true or false.")
    until_us = message.get("until_us")
    if until_us is not None and type(until_us) is not int:
        raise UsageError("until_us is a time in µs.")
    if op == "tell":
        return _read_tell(message)
    if op == "latch":
        return _read_latch(message)
    will = None if message.get("will") is None else read_will(message["will"])
    return Request(op, number, client, token, tuple(lines) if op == "hello" else (), levels, will, until_us)


def _read_tell(message: dict[str, Any]) -> Request:
    predicates, at_us = message.get("predicates"), message.get("at_us")
    if not (
        isinstance(predicates, dict)
        and 0 < len(predicates) <= MOST_PREDICATES
        and all(isinstance(holds, bool) for holds in predicates.values())
        and all(len(name) <= 64 for name in predicates)
    ):
        raise UsageError("predicates is an object of names, each true or false.")
    if type(at_us) is not int:
        raise UsageError("at_us is a time in µs.")
    return Request("tell", message.get("id"), predicates=predicates, at_us=at_us)


def _read_latch(message: dict[str, Any]) -> Request:
    fault, why = message.get("fault"), message.get("why")
    if not (isinstance(fault, str) and 0 < len(fault) <= 64):
        raise UsageError("fault is a name of at most 64 letters.")
    if not (isinstance(why, str) and 0 < len(why) <= 500):
        raise UsageError("why is a sentence of at most 500 letters.")
    return Request("latch", message.get("id"), fault=fault, why=why)


def write_message(message: Mapping[str, object]) -> bytes:
    """As a line."""
    return json.dumps(message, separators=(",", ":")).encode() + b"\n"
