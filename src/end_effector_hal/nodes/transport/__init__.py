"""The contract between the nodes and a ROS generation: the protocol, the messages, and which messages are accepted."""

from ._commander import Commander
from ._frames import (
    AMBIENT_PA,
    Frames,
    SharedFrames,
    StampCheck,
    absolute_pa,
    frame_from_message,
    frame_to_message,
)
from ._messages import (
    CommandMessage,
    CylinderPositionMessage,
    DiagnosticMessage,
    DiagnosticsMessage,
    EventMessage,
    FeedbackMessage,
    FrameMessage,
    GripperMessage,
    JointStateMessage,
    KeyValueMessage,
    MessageHeader,
    ParallelGripperMessage,
    PositionMessage,
    PressureMessage,
    ResultMessage,
    StateMessage,
    StatusMessage,
    StepMessage,
)
from ._statuses import status_from_message, status_to_message
from ._transport import (
    ActionClient,
    ActionServer,
    ChangerPlace,
    ClientGoal,
    CommandClient,
    CylinderPlace,
    NodeTransport,
)
from ._unknown_senders import UnknownSenders
