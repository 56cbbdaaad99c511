"""Times that decide when a robot proposes a view, and for how long it waits. Liveness only.

Other times stand beside the rules that they are for. No value here can break a safety rule: whatever they
are, bodies obey the fence alone (docs/strand.md).
"""

from dataclasses import dataclass, replace

from protocol.mission import Mission

ODOMETRY_S = 0.1  # the world's period
PATIENCE_S = 10.0  # in a turn, where obstacles move: as long as with a way in the strand that is blocked


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """The times of one fleet [s]; `relations` names what must hold between them."""

    report_s: float = 0.1
    """A report is repeated until it is answered: with every odometry."""
    ping_s: float = 0.5
    """An answered one is repeated: the answer shows that the coordinator is there."""
    put_s: float = 0.1
    """A put is repeated until odometry tells it."""
    draws_s: float = 0.05
    """A raise waits for a drawn time in [1, 2] of these, so that most robots see the first one."""
    shared_draws_s: float = 0.5
    """What all robots may want at once waits for a drawn time in [0, 1] of these: an odometry for each."""
    slower_max: int = 3
    """Waiting for what a coordinator or a robot says doubles with each such epoch, so often at most."""
    doublings_max: int = 2
    """The drawn time doubles with each epoch in a row without ALL, so often at most."""
    gap_s: float = 0.8
    """A robot that has had no odometry for so long has slept, or is cut off."""
    listens_s: float = 1.5
    """After that it listens so long before it judges others' silence."""
    reports_s: float = 1.25
    """The coordinator waits so long for robots that show a token and have not reported."""
    looks_s: float = 3.0
    """The coordinator waits so long for a robot to look at its leg, or to tell a newer place or a map."""
    turn_s: float = 12.0
    """It takes a turn back when the robot has stood for so much longer than it has driven."""
    coordinator_s: float = 1.5
    """A coordinator is lost when there has been no word from it and no new turn for so long."""
    stood_s: float = 20.0
    """It is lost, whatever it says, when no body has moved and there was no new turn for so long."""
    silent_s: float = 8.0
    """A neighbour with a token is lost when it has been silent for so long. After 4 s there were a fifth more
    views for lost neighbours where a robot loses nine of ten messages (docs/measured.md)."""
    comes_back_s: float = 5.0
    """Before a strand goes on without robots that were there lately: a process that is started again is there
    after two seconds."""
    plea_s: float = 1.0
    """A robot that is left out asks so often."""
    plea_again_s: float = 2.0
    """The same robot is let in again after so long; each time twice as long."""
    plea_again_s_max: float = 60.0
    outsider_s: float = 10.0
    """One that has had no answer to its pleas for so long proposes a view as an outsider."""

    @classmethod
    def of(cls, mission: Mission) -> "Timing":
        """The times of a fleet: in a large one each robot speaks less often to the coordinator."""
        ping_s = max(0.5, 0.01 * mission.robots)  # 100 reports a second for the coordinator
        report_s = max(0.1, 0.002 * mission.robots)  # 500 a second, until they are answered
        return cls(
            ping_s=ping_s,
            report_s=report_s,
            coordinator_s=3.0 * ping_s,
            reports_s=2.5 * ping_s,
            shared_draws_s=ODOMETRY_S * mission.robots,
        )

    def slower(self, in_vain: int) -> "Timing":
        """The times after so many epochs in a row without ALL: most messages may be lost."""
        times = 2.0 ** max(0, min(in_vain, self.slower_max))
        return replace(
            self,
            coordinator_s=times * self.coordinator_s,
            reports_s=times * self.reports_s,
            looks_s=min(times * self.looks_s, self.stood_s / 2.0),
        )

    def __post_init__(self) -> None:
        for name, holds in self.relations().items():
            if not holds:
                raise ValueError(f"times do not fit together: {name}")

    def relations(self) -> dict[str, bool]:
        """What must hold, by name."""
        return {
            "three pings in a row are lost before a coordinator is": self.coordinator_s >= 3.0 * self.ping_s,
            "a robot that cannot hear the coordinator is left out before it raises": self.reports_s
            < self.coordinator_s,
            "a report is tried several times before it is waited for in vain": self.reports_s
            >= 5.0 * self.report_s,
            "a put is seen before it is repeated": self.put_s >= ODOMETRY_S,
            "a stuck turn is taken back before the coordinator is given up": self.turn_s <= self.stood_s,
            "a robot that is patient in its turn is not taken for a stuck one": self.turn_s > PATIENCE_S,
            "who has slept listens for longer than it slept": self.listens_s > self.gap_s,
            "a silent robot is given up before all that wait are": self.silent_s < self.stood_s,
            "nobody is given up for a pause in which all wait": self.comes_back_s < self.stood_s,
            "a raise is seen before most others are made": 2.0 * self.draws_s >= ODOMETRY_S,
        }
