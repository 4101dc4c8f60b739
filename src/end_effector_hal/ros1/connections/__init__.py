"""Messages and calls in ROS 1: their types, how they are sent, and which senders are accepted."""

from ._command_service import CommandService
from ._direct_send import send_directly
from ._known_publishers import KnownPublishers, caller_of, nodes_of
from ._messages import MessageMaker, answer_of, message_class, response_maker, service_class
from ._publish import publisher
