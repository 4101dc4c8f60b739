"""The messages between the arbiter and its clients; `_request` describes them."""

from ._message import read_json, read_message, read_reply, write_json, write_message
from ._request import SENSORS, LastWillRunsError, Request, is_token, make_token, read_id, read_request
