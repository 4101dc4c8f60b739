"""Messages and services in ROS 2: their types and their quality of service."""

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
