"""Explores one setting, with ever more faults, and tells what was covered."""

from collections.abc import Iterator
from time import process_time

from msgspec import Struct

from clew.explore.explorable import Breach
from clew.explore.fleet import Fleet
from clew.explore.recovering import RecoveringFleet
from clew.explore.search import Explored, Strike, at_once, deepen, retell
from clew.explore.setting import Setting


class Round(Struct, frozen=True, kw_only=True):
    """An exploration with at most so many faults."""

    setting: str
    deliveries: int
    explored: Explored
    core_steps: int
    """Steps of single cores that were computed so far; all other steps were remembered."""
    cpu_s: float
    slowest_s: float | None = None
    """The longest time until a fleet had recovered, of those that have to."""


def explore(setting: Setting, faults_max: int, seconds: float, *, recovers: bool = False) -> Iterator[Round]:
    """Explore without faults, with one, and so on, for at most so many seconds of CPU.

    Args:
        setting: what is explored.
        faults_max: how many faults a schedule has at most.
        seconds: of CPU.
        recovers: whether the fleet has to recover after the faults (`clew.explore.recovering`).
    """
    began_s = process_time()
    try:
        fleet = RecoveringFleet(setting) if recovers else Fleet(setting)
    except Breach as breach:  # before any fault
        yield Round(setting=setting.name, deliveries=0, explored=at_once(breach), core_steps=0, cpu_s=0.0)
        return
    for explored in deepen(fleet, faults_max, lambda: process_time() - began_s < seconds):
        yield Round(
            setting=setting.name,
            deliveries=setting.deliveries,
            explored=explored,
            core_steps=fleet.cores.computed,
            cpu_s=process_time() - began_s,
            slowest_s=fleet.slowest_s if isinstance(fleet, RecoveringFleet) else None,
        )


def story(setting: Setting, strikes: tuple[Strike, ...], *, recovers: bool = False) -> Iterator[str]:
    """A schedule that is given by its faults, from the first of them on, to its end or its breach."""
    fleet = RecoveringFleet(setting) if recovers else Fleet(setting)
    struck = not strikes
    try:
        for rank, said, fault in retell(fleet, strikes):
            struck = struck or fault is not None
            if struck:
                yield (
                    f"{rank[0]}.{rank[1]} {said}"
                    if fault is None
                    else f"{rank[0]}.{rank[1]} FAULT {fault}: {said}"
                )
    except Breach as breach:
        yield f"broken: {breach}"
