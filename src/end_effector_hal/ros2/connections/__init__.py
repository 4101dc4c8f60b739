"""Messages and calls in ROS 2: types, quality of service, accepted senders, and direct delivery within a process."""

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
