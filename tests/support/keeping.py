"""Lines and policies for a rules in virtual time."""

from end_effector_hal.arbiter import Policy
from end_effector_hal.arbiter.rules._policy import Need

UNLOCK, BOTTOM, CYLINDER, TOP = LINES = ("unlock", "bottom", "cylinder", "top")
GRIP = (BOTTOM, CYLINDER, TOP)
MS, S = 1_000, 1_000_000
TOKEN, OTHER = "a" * 32, "b" * 32
POLICY = Policy(
    LINES, tuple((UNLOCK, line) for line in GRIP), {UNLOCK: 3 * S}, labels={UNLOCK: "tool changer"}
)
FREE = Need("free", "IL-01", "nothing is gripped", "the sensors do not prove that nothing is gripped")
LOCKED = Need("locked", "IL-05", "the tool is locked", "the tool is not proven to be locked")
CLOSED = Need(
    "closed", "IL-13", "the e-stop is closed", "the e-stop is open", latched="the e-stop was opened"
)
SENSING = Policy(LINES, needs={UNLOCK: (CLOSED, FREE), **dict.fromkeys(GRIP, (CLOSED, LOCKED))})


class Lines:
    """A back-end that notes every write with the time at which the rules was asked."""

    def __init__(self, **active):
        self.now, self.written, self.state = 0, [], dict.fromkeys(LINES, False) | active
        self.error = None

    def request(self, names):
        assert list(names) == list(LINES)
        return dict(self.state)

    def levels(self):
        return dict(self.state)

    def set(self, levels):
        if self.error:
            raise self.error
        self.written += [(self.now, line, level) for line, level in levels.items()]
        self.state |= levels

    def close(self):
        pass
