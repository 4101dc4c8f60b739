"""The messages between the arbiter and its clients; `_request` describes them."""

from ._errors import LastWillRunsError
from ._message import LONGEST, read_message, read_reply, write_message
from ._request import SENSORS, Request, read_id, read_request
from ._token import is_token, make_token

__all__ = [
    "LONGEST",
    "SENSORS",
    "LastWillRunsError",
    "Request",
    "is_token",
    "make_token",
    "read_id",
    "read_message",
    "read_reply",
    "read_request",
    "write_message",
]
