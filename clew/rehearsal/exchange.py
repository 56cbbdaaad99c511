"""Delivers mail between the processes of a rehearsal. The fault plan decides at the receiver.

Rule 1: delivery takes no time, except for delays by the fault plan.
Rule 2: the receiver counts each mail once, when it arrives: as received, or as lost to a named fault.
"""

from msgspec import Struct

from clew.rehearsal.actor import Actor, Arrival, Desk
from clew.rehearsal.mail import Mail
from clew.rehearsal.network import Network
from protocol.faults.message_faults import MessageFaults
from protocol.faults.plan import Plan
from protocol.timeline import FaultInjected


class Opened(Struct, frozen=True, gc=False):
    """The effect of the fault plan on one mail: arrivals with their delays, and entries to record."""

    arrivals: tuple[tuple[float, Arrival], ...]
    records: tuple[FaultInjected, ...] = ()


class Exchange:
    """The mail of a run."""

    def __init__(self, plan: Plan, seed: int) -> None:
        self.message_faults = MessageFaults(plan, seed)
        self.network: Network[tuple[Actor | Desk, Arrival]] = Network()

    def use(self, faults: MessageFaults) -> None:
        """Use these effects from now on; messages in transit are not affected."""
        self.message_faults = faults

    def open(self, mail: Mail, receiver: Actor | Desk, *, now_s: float, step: int) -> Opened:
        """Let the fault plan decide on the mail, and count it at the receiver."""
        if self.message_faults.is_empty:
            if mail.number > 0:
                receiver.traffic.receive(mail.key, mail.number)
            return Opened(((0.0, Arrival(mail)),))
        effect = self.message_faults.of(
            mail.key, mail.kind, mail.number, receiver.name, now_s=now_s, step=step
        )
        if mail.number > 0:
            if (fault := effect.removed_by) is None:
                receiver.traffic.receive(mail.key, mail.number)
            else:
                receiver.traffic.count_removed(mail.key, mail.number, fault)
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
        """Count mail that is lost because the process `down` is down. No entry records it."""
        if mail.number > 0:
            receiver.traffic.count_removed(mail.key, mail.number, down)
