"""What a run consists of, and how long and how often its supervisor tries."""

from dataclasses import dataclass, replace

AS_ROBOTS = 5  # of 200 fleets at load 120, the world had judged 64 after 10 s
FLEET = 200  # robots: a fleet of so many ends in the times below on two cores; of 1000, the world took 7 s


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Which parts a run has beside its world and its host."""

    routers: int = 1
    """0: the user runs one."""
    view: bool = False
    table: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """How long a supervisor waits, by a clock that nobody sets, and how often it starts a part again."""

    ready_s: float = 60.0  # for a router to listen: it takes 0.3 s, and 12 s beside 40 busy processes
    page_s: float = 10.0  # for the viewer to say where its page is: a run does not need it
    grace_s: float = 1.5  # for the world to notice by itself that robots have died: it takes 1 s to be sure
    world_s: float = 3.0  # for the world to close its books and write its verdict
    others_s: float = 0.4  # for router and robots, which have nothing left to do by then
    killed_s: float = 0.4  # for the kernel to end what was killed
    all_s: float = 4.8  # of the 5 s in which everything has to be gone; the rest is for the report
    router_restarts_max: int = 10  # in one run: enough for any plan, and an end to a router that cannot live
    world_restarts_max: int = 5

    def __post_init__(self) -> None:
        if not max(self.grace_s, self.world_s) < self.world_by_s:
            raise ValueError(
                "all_s must exceed others_s + killed_s and the longer of grace_s and world_s "
                f"({self.all_s - self.world_by_s + max(self.grace_s, self.world_s):g}), got {self.all_s:g}"
            )

    @property
    def world_by_s(self) -> float:
        """From the first sign of the end to the end of the world."""
        return self.all_s - self.others_s - self.killed_s


def limits_of(robots: int, *, fleets: int = 0, is_resumable: bool) -> Limits:
    """The limits of a run: a large fleet needs more time to end, since its processes share the cores.

    Args:
        robots: how many there are.
        fleets: how many they are, where there are several: the world judges one after the other.
        is_resumable: whether its world can be started again.
    """
    longer, usual = max(1.0, (robots + AS_ROBOTS * fleets) / FLEET), Limits()
    return replace(
        usual,
        grace_s=longer * usual.grace_s,
        world_s=longer * usual.world_s,
        others_s=longer * usual.others_s,
        killed_s=longer * usual.killed_s,
        all_s=longer * usual.all_s,
        world_restarts_max=usual.world_restarts_max if is_resumable else 0,
    )
