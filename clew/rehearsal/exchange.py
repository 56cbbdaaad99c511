"""How mail gets from process to process in a rehearsal: the fault plan decides on it where it is received.

Rule 1: the way itself takes no time; what takes time is what the fault plan does.
Rule 2: mail that came counts once at its receiver, when it comes: as received, or as taken away, and by what.
"""

from msgspec import Struct

from clew.rehearsal.actor import Actor, Arrival, Desk
from clew.rehearsal.mail import Mail
from clew.rehearsal.network import Network
from protocol.faults.message_faults import MessageFaults
from protocol.faults.plan import Plan
from protocol.timeline import FaultInjected


class Opened(Struct, frozen=True):
    """What has become of mail at its receiver: arrivals, each with a delay, and what is to be recorded."""

    arrivals: tuple[tuple[float, Arrival], ...]
    records: tuple[FaultInjected, ...] = ()


class Exchange:
    """All mail of a run."""

    def __init__(self, plan: Plan, seed: int) -> None:
        self.message_faults = MessageFaults(plan, seed)
        self.network: Network[tuple[Actor | Desk, Arrival]] = Network()

    def open(self, mail: Mail, receiver: Actor | Desk, *, now_s: float, step: int) -> Opened:
        """Ask the fault plan, and keep the receiver's books."""
        effect = self.message_faults.of(
            mail.key, mail.kind, mail.number, receiver.name, now_s=now_s, step=step
        )
        if mail.number > 0:
            if (fault := effect.taken_away) is None:
                receiver.traffic.receive(mail.key, mail.number)
            else:
                receiver.traffic.take_away(mail.key, mail.number, fault)
        if not effect.injections:
            return Opened(((0.0, Arrival(mail)),))
        return Opened(
            tuple((copy.delay_s, Arrival(mail, copy.damage)) for copy in effect.copies),
            tuple(
                FaultInjected(fault=each.fault, rule=each.rule, key=mail.key, number=mail.number)
                for each in effect.injections
            ),
        )

    def lose(self, mail: Mail, receiver: Actor | Desk, down: str) -> None:
        """Count mail that finds a process down on its way, by that process's name; nobody can record it."""
        if mail.number > 0:
            receiver.traffic.take_away(mail.key, mail.number, down)
