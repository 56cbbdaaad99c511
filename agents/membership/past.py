"""What a robot takes along from one view to the next."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self

from agents.membership.places import OldPlace, Places
from agents.strand.member import Member
from protocol.fence import Epoch
from protocol.frames import Point
from protocol.wire.view import Counters


@dataclass(frozen=True, slots=True)
class Past:
    """A robot's places, and what the fleet had counted in the last strand that it was in."""

    places: Places = field(default_factory=Places)
    counters: Counters = field(default_factory=Counters)
    counted: Epoch = field(default_factory=Epoch)
    """The formation that the counters are from."""
    arrived: bool = False
    """Whether the robot stood at its place at the goal."""
    neighbours: Mapping[int, Point] = field(default_factory=dict)
    """Where its neighbours were when it last heard them."""

    def with_places(self, places: Places) -> Self:
        """After a view: the robot may have left its places, or have one in the draft."""
        return replace(self, places=places)

    def with_strand(self, member: Member) -> Self:
        """After a strand; a robot that did not stand at its place in it has no place on its path."""
        formation = member.formation
        place = OldPlace(
            formation.epoch, formation.rank, member.progress_m, member.path, behind_m=member.strand.behind_m
        )
        places = self.places.with_old(place, moved=member.has_moved) if member.fits else Places()
        neighbours = {**self.neighbours, **member.strand.neighbours}
        return type(self)(places, member.counters, formation.epoch, member.arrived, neighbours)
