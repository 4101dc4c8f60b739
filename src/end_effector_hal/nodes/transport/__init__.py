"""The contract between the nodes and a ROS generation: the protocol and the messages."""

from ._messages import (
    AMBIENT_PA,
    RESPONSE_FIELDS,
    CommandMessage,
    CylinderPositionMessage,
    DiagnosticMessage,
    DiagnosticsMessage,
    EventMessage,
    FeedbackMessage,
    GoalMessage,
    GripperMessage,
    JointStateMessage,
    KeyValueMessage,
    MessageHeader,
    ParallelGripperMessage,
    PositionMessage,
    PressureMessage,
    ResultMessage,
    StateMessage,
    StepMessage,
    answer_of,
    has_ros_class,
    ros_class,
)
from ._transport import ActionClient, ActionServer, ClientGoal, NodeTransport
