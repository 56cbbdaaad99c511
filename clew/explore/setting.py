"""What is explored: a small world, how a run begins there, which faults may strike, and for how long."""

from enum import StrEnum
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from clew.explore.explorable import Fault
from protocol.errors import UsageError
from protocol.files.reading import understand
from world.scenario.scenario import Scenario

TICKS_PER_S = 50
NEVER_TICKS = 10**6


class Kind(StrEnum):
    """The kinds of faults; each costs one fault."""

    LOSE = "lose"  # the first letter in line is lost
    LATE = "late"  # it arrives so many ticks later; 0: after all that is in line
    TWICE = "twice"  # it arrives now, and once more so many ticks later
    KILL = "kill"  # its receiver dies before it arrives; it is started again after so many ticks, or never
    CUT = "cut"  # a robot hears nothing and is not heard for so many ticks
    WORLD = "world"  # the world is killed and started again


class Setting(Struct, frozen=True, kw_only=True):
    """One setting of an exploration."""

    name: str
    about: str
    """What it explores, in one sentence."""
    places: tuple[tuple[float, float, float], ...]
    """Where the robots stand at first: x, y [m], heading [rad]."""
    goal_m: tuple[float, float] = (3.4, 1.5)
    obstacles: tuple[tuple[float, float, float], ...] = ((2.5, 2.3, 0.15),)
    """Circles: x, y, radius [m]."""
    obstacle_speed_mps_max: float = 0.0
    size_m: tuple[float, float] = (4.0, 3.0)
    separation_m: float = 0.05
    link_length_m_max: float = 1.0
    has_way_for_all: bool = True
    """Whether all robots can be in one strand."""
    opens_ticks: int = 0
    """The window for faults opens then."""
    before: tuple[tuple[int, Fault], ...] = ()
    """What strikes before that, at which tick or soon after; LATE: the first order to move of that robot."""
    skips: int = 0
    """And after so many letters more."""
    deliveries: int = 20
    """It is open for as long as so many letters take without faults."""
    faults: int = 2
    """How many faults a schedule has at most, unless somebody asks for more."""
    settle_ticks: int = 3 * TICKS_PER_S
    """How long the fleet goes on after that."""
    kinds: tuple[Kind, ...] = tuple(Kind)
    delays_ticks: tuple[int, ...] = (5, 50)
    restarts_ticks: tuple[int, ...] = (10, NEVER_TICKS)
    cuts_ticks: tuple[int, ...] = (25, 100)

    def scenario(self) -> Scenario:
        """The world, without any noise: an open field with few obstacles."""
        raw: dict[str, Any] = {
            "name": f"explore-{self.name}",
            "fleet": {
                "robots": len(self.places),
                "robot_radius_m": 0.1,
                "separation_m": self.separation_m,
                "link_length_m_max": self.link_length_m_max,
                "places": [list(place) for place in self.places],
            },
            "law": {"law": "certified", "epsilon_m": 0.1, "mu0_m": 0.01},
            "goal": {"at_m": list(self.goal_m), "tolerance_m": 0.15},
            "bounds": {"x_m_min": 0.0, "x_m_max": self.size_m[0], "y_m_min": 0.0, "y_m_max": self.size_m[1]},
            "sensor": {"directions": 360, "range_m_max": 3.0, "range_sigma_m": 0.0},
            "drive": {
                "speed_mps": 0.5,
                "speed_mps_min": 0.05,
                "speed_mps_max": 1.0,
                "turn_rate_radps": 3.0,
                "heading_error_rad": 0.0,
            },
            "time": {"time_s_max": 600.0},
            "obstacle_speed_mps_max": self.obstacle_speed_mps_max,
            "obstacle": [
                {"shape": "circle", "centre_m": [x_m, y_m], "radius_m": radius_m}
                for x_m, y_m, radius_m in self.obstacles
            ],
        }
        return understand(raw, Scenario, self.name)


def adjusted(
    setting: Setting, *, robots: int | None = None, deliveries: int | None = None, skips: int | None = None
) -> Setting:
    """The setting with other bounds.

    Raises:
        UsageError: it has fewer robots.
    """
    if robots is not None and robots > len(setting.places):
        raise UsageError(f"the setting {setting.name} has {len(setting.places)} robots, not {robots}")
    return replace(
        setting,
        places=setting.places[:robots],
        deliveries=setting.deliveries if deliveries is None else deliveries,
        skips=setting.skips if skips is None else skips,
    )


QUEUE = ((1.3, 1.5, 0.0), (0.9, 1.5, 0.0), (0.5, 1.5, 0.0))
SCATTERED = ((1.2, 1.5, 0.0), (0.8, 1.0, 0.0), (0.7, 2.1, 0.0))
POCKET = (
    *((0.6 + 0.16 * post, y_m, 0.08) for post in range(9) for y_m in (1.14, 1.86)),
    *((2.04, 1.14 + 0.16 * post, 0.08) for post in range(6)),
)
"""Posts around a pocket that is open at the left."""
WALL = tuple((2.0, 0.1 + 0.16 * post, 0.08) for post in range(18))

SETTINGS = {
    setting.name: setting
    for setting in (
        Setting(name="start", about="three robots in a queue form a strand", places=QUEUE),
        Setting(name="turns", about="three scattered robots form a strand by turns", places=SCATTERED),
        Setting(name="drive", about="a strand drives", places=QUEUE, opens_ticks=100),
        Setting(
            name="heal",
            about="the leader has died, and the others form a strand",
            places=QUEUE,
            before=((80, Fault(Kind.KILL, 1, NEVER_TICKS)),),
            opens_ticks=100,
        ),
        Setting(
            name="cut",
            about="the leader has been cut off and drives on, while the others form a strand",
            places=QUEUE,
            before=((80, Fault(Kind.CUT, 1, 100)),),
            opens_ticks=148,
        ),
        Setting(
            name="middle",
            about="the robot in the middle has died, and the last one finds another way to the leader",
            places=QUEUE,
            before=((80, Fault(Kind.KILL, 2, NEVER_TICKS)),),
            opens_ticks=100,
        ),
        Setting(
            name="orders",
            about="a wall is between the robots, which try several orders in vain",
            places=((2.6, 1.5, 0.0), (1.4, 1.2, 0.0), (1.0, 1.8, 0.0)),
            obstacles=WALL,
            opens_ticks=226,
            has_way_for_all=False,
        ),
        Setting(
            name="rejoin",
            about="the last robot has been started again, and joins",
            places=QUEUE,
            before=((80, Fault(Kind.KILL, 3, 10)),),
            opens_ticks=100,
        ),
        Setting(
            name="round",
            about="a strand turns round in a dead end",
            places=((1.6, 1.5, 0.0), (1.25, 1.5, 0.0), (0.9, 1.5, 0.0)),
            goal_m=(3.0, 1.5),
            obstacles=POCKET,
            opens_ticks=206,
            has_way_for_all=False,  # the body of one that dies may plug the pocket
        ),
        Setting(
            name="late",
            about="the first order of the robot that has the turn is late",
            places=SCATTERED,
            before=((5, Fault(Kind.LATE, 3, 20)),),
            opens_ticks=12,
        ),
    )
}
