"""Messages between the line arbiter and its clients: a JSON object per line, on a Unix stream socket.

Requests have ``op``, and an ``id`` (an integer or a short text) that the reply repeats::

    {"id": 1, "op": "hello", "client": "grip", "token": "5be0cd191f83d9ab9b05688c2b3e6c1f",
                           "lines": ["SODIMM_208"], "will": [], "faults": {}}
    {"id": 2, "op": "set", "levels": {"SODIMM_208": true},
                           "will": [{"line": "SODIMM_208", "level": false, "after_us": 0}],
                           "until_us": 815000000}
    {"id": 3, "op": "renew"}
    {"id": 4, "op": "levels"}
    {"id": 5, "op": "status"}
    {"id": 6, "op": "bye", "will": []}
    {"id": 7, "op": "latch", "fault": "sensor_fault", "why": "IL-04: both bits of the tool changer are set."}
    {"id": 8, "op": "reset"}
    {"id": 9, "op": "stop"}
    {"id": 10, "op": "clear", "fault": "sensor_fault"}

    {"id": 1, "op": "hello", "role": "sensors", "client": "pressure", "token": "0d5f6c6e2b8a4f0d9b7e3a1c5d2f4b68"}
    {"op": "tell", "predicates": {"locked": true}, "at_us": 815000000}

**Writing lines.** ``hello`` names the lines that the client will write; each line has one writing client. ``token``
is 32 random digits from 0 to f, made once by the client: a client with the same name and token is the one before,
which connects again after a lost connection or a restart of the arbiter; any other is another program, and the last
will of the one before is executed. A pid would not tell them apart: the arbiter sees pid 0 for every client in a PID
namespace of its own, as in a container. Tokens are shown to nobody. While the last will of the client before is
executed, ``hello`` is refused with the code EE-402 and ``retry_us``: a last will runs to its end first, so that the
next client adopts lines that do not change. ``set`` is atomic, and leaves a last will (left out: the one before stays
valid); an empty last will holds. With ``"drop": true`` a person asked for what it deactivates: that is written also
where it counts as inactive already, and a device on a bus may be acknowledged and activated before it, as described,
unless an interlock refuses an activation now. After ``until_us`` (monotonic clock; left out: no limit) the whole
``set`` is refused, because its sender has stopped waiting for it. ``renew`` renews the lease and is answered with the
latched ``faults``; any ``set`` renews it, too. ``bye`` ends in order: the last will in it is executed at once, the
one left before is void. A socket that is closed without it, or a lease that expires, is the death of the client: its
last will is executed. The last step of a last will is due at most 10 s after the death, or as late as the description
of the tool needs it.

**Predicates.** The clients that write lines cannot report what the sensors prove. A ``hello`` with the role
``sensors`` takes that role for its connection; there is one at a time. Another connection is refused with EE-402 while
the first one sends, and a fault is latched: another process claims to read the sensors. A connection with the token
and the user (SO_PEERCRED) of the first one counts as the first one. Once the first was silent for 150 ms, another
process of the same user may take the role; one of another user only when the connection has ended, which the arbiter
does after 10 s of silence. ``tell`` counts only from the connection with this role. It is sent on change and at least
every 50 ms, and says what was proven at ``at_us`` (monotonic clock, never ahead of now). It names only predicates
that a line needs and that the arbiter does not prove by input lines of its own. It counts for 150 ms from then on. A
line whose activation needs a predicate (IL-01, IL-02, IL-05, IL-07, IL-13) is refused without it;
nothing is ever deactivated because one is missing. Without an ``id`` it gets no reply
unless it is refused.

**Faults.** ``latch`` keeps a fault of a client that writes lines, by a name that the arbiter's policy lists, through
a restart; ``status`` shows it, and it refuses nothing. ``clear`` ends it: the client says so once it has been reset
itself. The policy names the client that shows a fault: that one may also clear a fault that it has not latched, which
a disk has given back late, and finds it in ``status``. A ``hello`` has all faults that the client has latched and not
cleared: what it said to an arbiter or over a connection that was lost counts (left out: those that its last session
had). What the arbiter latches itself for an interlock (IL-03, IL-13) has no limit that a client could use up.
``reset`` clears all faults; it is refused with EE-403 for those whose cause persists (an open e-stop). A fault of a
client that lives, and has not cleared it, stays as well, whichever client has latched it (restart a client that never
shows it): the reply has ``stays``, a sentence by name. ``stop`` latches what an open e-stop latches (IL-13): until a
reset, also through a restart, nothing is activated, and no line is changed. A program that
hears of it cancels the grip that runs.

``levels``, ``status``, ``reset`` and ``stop`` need no hello: they change no line and no lease, a reset clears only what
is over, and a stop only refuses. Such a connection is closed after 10 s without a message, and the oldest of them when
there are more than 32: connections that write lines or send predicates do not count among these.

Replies: ``{"id", "ok", "error", "levels"}``, levels of all lines, active is true. ``error`` is a sentence, with
``code`` (see `end_effector_hal.errors`); it begins with the id of the interlock that refuses. Further keys: ``stays``
of ``reset``, ``delay_us`` of ``set`` (until it is applied, IL-10), ``retry_us``, ``overtaken`` of ``hello`` (the client
was declared dead before), ``status``. A reply with the id null belongs to no request: the arbiter ends the connection
and says why.

Every text has printable characters only, a name at most 64, a sentence at most 500; numbers are integers of at most
18 digits. A message has at most 128 lines, 528 predicates and 262,144 bytes: what a tool of 64 actuators needs.
"""

from __future__ import annotations

import re
import secrets
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeGuard

from end_effector_hal.errors import LineBusyError, UsageError
from end_effector_hal.vocabulary import MOST_LINES, MOST_PREDICATES, LastWill, is_name, read_last_will


class LastWillRunsError(LineBusyError):
    """The last will of the client that had these lines is still being executed.

    Args:
        what: one sentence.
        retry_us: how long that takes, µs; say hello again after it.
    """

    def __init__(self, what: str, retry_us: int) -> None:
        super().__init__(what)
        self.retry_us = retry_us


MOST_FAULTS = 16
"""Of one client."""
_TOKEN = re.compile("[0-9a-f]{32}")


def make_token() -> str:
    """A new token."""
    return secrets.token_hex(16)


def is_token(given: object) -> TypeGuard[str]:
    """Whether it is 32 digits from 0 to f."""
    return isinstance(given, str) and _TOKEN.fullmatch(given) is not None


OPS = ("hello", "set", "renew", "levels", "status", "bye", "tell", "latch", "clear", "reset", "stop")
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
    drop: bool = False
    predicates: Mapping[str, bool] = {}
    at_us: int = 0
    fault: str = ""
    why: str = ""
    faults: Mapping[str, str] | None = None


def read_id(message: Mapping[str, Any]) -> int | str | None:
    """The id that the reply repeats; None: there is none.

    Raises:
        UsageError: it is neither an integer nor a short text.
    """
    number = message.get("id")
    if number is None or type(number) is int or is_name(number):
        return number
    raise UsageError("id must be an integer or a text of at most 64 characters.")


def read_request(message: Mapping[str, Any]) -> Request:
    """Check every field.

    Raises:
        UsageError: says which one is wrong.
    """
    op = message.get("op")
    if op not in OPS:
        raise UsageError(f"op must be one of {', '.join(OPS)}.")
    reader = {
        "hello": _read_hello, "set": _read_set, "tell": _read_predicates, "latch": _read_latch, "clear": _read_clear,
    }.get(op)  # fmt: skip
    return reader(message) if reader else Request(op, will=_read_last_will(message))


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
    drop = message.get("drop", False)
    if not (_is_flags(levels, MOST_LINES) and (levels or "will" in message)):
        raise UsageError(f"levels must be an object of at most {MOST_LINES} line names, each true or false.")
    if until_us is not None and type(until_us) is not int:
        raise UsageError("until_us must be a time in µs.")
    if not isinstance(drop, bool):
        raise UsageError("drop must be true or false.")
    return Request("set", levels=levels, will=_read_last_will(message), until_us=until_us, drop=drop)


def _read_predicates(message: Mapping[str, Any]) -> Request:
    predicates, at_us = message.get("predicates"), message.get("at_us")
    if not (predicates and _is_flags(predicates, MOST_PREDICATES)):
        raise UsageError(f"predicates must be an object of 1 to {MOST_PREDICATES} names, each true or false.")
    if type(at_us) is not int:
        raise UsageError("at_us must be a time in µs.")
    return Request("tell", predicates=predicates, at_us=at_us)


def _read_latch(message: Mapping[str, Any]) -> Request:
    why = message.get("why")
    if not (isinstance(why, str) and why):
        raise UsageError("why must be a sentence.")
    return Request("latch", fault=_read_fault(message), why=why)


def _read_clear(message: Mapping[str, Any]) -> Request:
    return Request("clear", fault=_read_fault(message))


def _read_fault(message: Mapping[str, Any]) -> str:
    fault = message.get("fault")
    if not is_name(fault):
        raise UsageError("fault must be a name of at most 64 printable characters.")
    return str(fault)


def _read_last_will(message: Mapping[str, Any]) -> LastWill | None:
    return None if message.get("will") is None else read_last_will(message["will"])


def _is_sentences(given: object) -> TypeGuard[dict[str, str]]:
    return (
        isinstance(given, dict)
        and len(given) <= MOST_FAULTS
        and all(is_name(name) and isinstance(why, str) and why for name, why in given.items())
    )


def _is_flags(given: object, most: int) -> bool:
    """Whether it is an object of at most so many names, each true or false."""
    return (
        isinstance(given, dict)
        and len(given) <= most
        and all(is_name(name) and isinstance(value, bool) for name, value in given.items())
    )
