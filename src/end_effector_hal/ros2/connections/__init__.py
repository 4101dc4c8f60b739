"""Messages and calls in ROS 2: their types, their quality of service, whose count, and the short way in a process."""

from ._command_service import LocalService, RclpyCommandService
from ._local_bus import LocalBus
from ._messages import (
    RclpyMessageMaker,
    action_class,
    answer_of,
    has_action_class,
    message_class,
    reader_quality,
    response_maker,
    service_class,
    writer_quality,
)
from ._publishers_in_graph import PublishersInGraph
