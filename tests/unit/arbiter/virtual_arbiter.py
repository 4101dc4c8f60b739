"""The rules of the line arbiter in virtual time, with two clients."""

from end_effector_hal.arbiter import LineArbiter
from end_effector_hal.vocabulary import LastWillStep
from tests.support.keeping import (
    BOTTOM,
    CYLINDER,
    GRIP,
    MS,
    POLICY,
    TOKEN,
    TOP,
    UNLOCK,
    Lines,
    S,
)

UNWIND = (
    LastWillStep(TOP, False, 0),
    LastWillStep(CYLINDER, False, 2 * S),
    LastWillStep(BOTTOM, False, 4 * S),
)


class Arbiter:
    """The rules in virtual time, with two clients; between the steps it does what is due, when it is due."""

    def __init__(self, policy=POLICY, start=1 * S, **active):
        self.lines = Lines(**active)
        self.rules = LineArbiter(self.lines, policy, 0)
        self.now = 0
        self.alive = []
        self.to(start)
        self.lines.written.clear()
        self.grip = self.hello("grip", GRIP)
        self.changer = self.hello("changer", (UNLOCK,))

    def hello(self, client, lines, will=()):
        session = self.rules.hello(client, TOKEN, lines, will, self.now, pid=7)
        self.alive.append(session)
        return session

    def to(self, at):
        """Time passes; the living renew their leases."""
        while True:
            for session in self.alive:
                self.rules.renew(session, self.now)
            step = min(at, max(self.rules.deadline or at, self.now))
            step = min(step, self.now + 500 * MS)
            self.now = self.lines.now = step
            self.rules.advance(step)
            if step >= at:
                return

    def set(self, session, will=None, **levels):
        return self.rules.write(session, levels, will, self.now)

    def die(self, session):
        self.alive.remove(session)
        self.rules.declare_dead(session, "killed", self.now)

    @property
    def written(self):
        return self.lines.written
