"""All key expressions of a fleet, defined in this one file.

A key contains sender and receiver, so a robot's access rights never change when the strand heals. It also
contains the run, so a late message of an earlier run has no receiver.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

WORLD = "world"
WORLD_NUMBER = 0  # robots count from 1
DIGITS_MAX = 9  # of a robot; a log may say any text where a name should be, and int() refuses long ones


def robot_name(robot: int) -> str:
    """The name of a robot in keys, messages and the timeline: 3 is `r3`."""
    return f"r{robot}"


@lru_cache(maxsize=4096)  # twice `ROBOTS_MAX`: the world calls this four times for every entry
def robot_number(name: str) -> int | None:
    """The number of the robot with this name, or None if the name is not a robot's."""
    digits = name[1:]
    is_number = digits.isascii() and digits.isdigit() and len(digits) <= DIGITS_MAX
    return int(digits) if name[:1] == "r" and is_number else None


def not_of_fleet(said: object, robots: int) -> str:
    """The refusal of a robot that a fleet of so many does not have."""
    return f"must be a robot of the fleet, r1 to {robot_name(robots)}, got {said}"


@dataclass(frozen=True)
class Keys:
    """The keys of one run of one fleet; `*` may stand for any sender or receiver."""

    fleet: str
    run: str

    @cached_property
    def root(self) -> str:
        """The prefix of all keys of the run."""
        return f"clew/{self.fleet}/{self.run}"

    @cached_property
    def _before(self) -> str:
        return f"{self.root}/"

    def link(self, sender: str, receiver: str) -> str:
        """A robot's newest link state for one neighbour."""
        return f"{self.root}/link/{sender}/{receiver}"

    def scan(self, robot: str) -> str:
        """Queryable of the world: a scan, taken when a robot asks."""
        return f"{self.root}/body/{robot}/scan"

    def drive(self, robot: str) -> str:
        """The robot's newest drive order."""
        return f"{self.root}/body/{robot}/drive"

    def odometry(self, robot: str) -> str:
        """The odometry of a body, for its robot."""
        return f"{self.root}/body/{robot}/odometry"

    def fence(self, robot: str) -> str:
        """What a robot puts to change the fence; robot 0 is the operator."""
        return f"{self.root}/body/fence/{robot}"

    def view(self, sender: str, receiver: str) -> str:
        """Reports, answers, formations and pleas of a view."""
        return f"{self.root}/view/{sender}/{receiver}"

    def mission(self) -> str:
        """Queryable of the world: the mission that every robot gets before it starts."""
        return f"{self.root}/mission"

    def log(self, source: str) -> str:
        """Timeline entries of one source, to the recorder."""
        return f"{self.root}/log/{source}"

    def logged(self, source: str) -> str:
        """The recorder's acknowledgement to one source."""
        return f"{self.root}/logged/{source}"

    def fault(self, robot: str) -> str:
        """The faults of one robot, from the world: rules for messages, and how slow the robot is."""
        return f"{self.root}/fault/{robot}"

    def alive(self, source: str, incarnation: str) -> str:
        """Liveliness token; the incarnation distinguishes a restarted source from its predecessor."""
        return f"{self.root}/alive/{source}/{incarnation}"

    def tokens_of(self, source: str) -> str:
        """The pattern of all liveliness tokens of a source."""
        return self.alive(source, "*")

    def pulse(self, source: str) -> str:
        """A key without receivers: a process sends on it to test whether its session still works."""
        return f"{self.root}/pulse/{source}"

    def behind_root(self, key: str) -> str:
        """A key without the prefix of the run, as in the books."""
        return key.removeprefix(self._before)

    def part(self, key: str, index: int) -> str:
        """One chunk of a key, counted after the root: in `…/link/r1/r2`, chunk 1 is `r1`."""
        return self.behind_root(key).split("/")[index]


def keys_of(robots: int) -> Iterator[str]:
    """All keys without the prefix of the run on which a fleet of so many robots sends messages."""
    keys = Keys("fleet", "run")
    names = [robot_name(robot) for robot in range(1, robots + 1)]
    yield keys.behind_root(keys.mission())
    for name in (WORLD, *names):
        yield from (keys.behind_root(key) for key in (keys.log(name), keys.logged(name)))
    for name in names:
        own = (keys.scan, keys.drive, keys.odometry, keys.fence, keys.fault)
        yield from (keys.behind_root(key(name)) for key in own)
        for other in names:
            if other != name:
                yield from (keys.behind_root(key(name, other)) for key in (keys.link, keys.view))


@lru_cache(maxsize=4096)  # a fault plan takes thousands of messages of the same few keys
def ends_of(key: str) -> tuple[str, str] | None:
    """The sender and the receiver on a key (without the run's root); None: of the recorder or of queries.

    The keys of the operator, who counts nothing, have none either.
    """
    match key.split("/"):
        case ["link" | "view", sender, receiver]:
            return sender, receiver
        case ["body", "fence", robot] if robot_number(robot) is not None:
            return robot, WORLD
        case ["body", robot, "drive"]:
            return robot, WORLD
        case ["body", robot, "odometry"]:
            return WORLD, robot
        case _:
            return None


def matches(pattern: str, key: str) -> bool:
    """Whether a key is one that a pattern means, in which `*` stands for one chunk."""
    parts, wanted = key.split("/"), pattern.split("/")
    return len(parts) == len(wanted) and all(w in ("*", p) for w, p in zip(wanted, parts, strict=True))
