"""Messages and calls in ROS 2: their types, their quality of service, whose count, and the short way in a process."""

from ._command_service import LocalService, RclpyCommandService
from ._local_bus import LocalBus
from ._messages import RclpyMessageMaker, answer_of, response_maker
from ._publishers_in_graph import PublishersInGraph
from ._quality import reader_quality, writer_quality
from ._types import action_class, has_action_class, message_class, service_class
