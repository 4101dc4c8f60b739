"""Messages and services in ROS 1: their types, and how they are sent."""

from ._messages import MessageMaker, answer_of, message_class, response_maker, service_class
from ._publish import encodable, publisher
