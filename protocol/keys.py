"""Every key expression of a fleet, spelt in this one file.

Sender and receiver stand in the key, so what a robot may say and hear never changes when the strand
heals. The run stands in the key, so a late message of the last run finds nobody.
"""

from dataclasses import dataclass
from functools import lru_cache

WORLD = "world"
WORLD_NUMBER = 0  # robots count from 1
DIGITS_MAX = 9  # of a robot; a log may say any text where a name should be, and int() refuses long ones


def robot_name(robot: int) -> str:
    """How keys, users and the timeline call a robot: 3 is `r3`."""
    return f"r{robot}"


@lru_cache(maxsize=4096)  # twice as many as there are robots: the world asks four times for every entry
def robot_number(name: str) -> int | None:
    """The robot behind a name, or None where it is not a robot's."""
    digits = name[1:]
    is_number = digits.isascii() and digits.isdigit() and len(digits) <= DIGITS_MAX
    return int(digits) if name[:1] == "r" and is_number else None


@dataclass(frozen=True, slots=True)
class Keys:
    """The keys of one run of one fleet; `*` may stand for any sender or receiver."""

    fleet: str
    run: str

    @property
    def root(self) -> str:
        """What all keys of the run start with."""
        return f"clew/{self.fleet}/{self.run}"

    def link(self, sender: str, receiver: str) -> str:
        """A robot's newest link state for one neighbour."""
        return f"{self.root}/link/{sender}/{receiver}"

    def scan(self, robot: str) -> str:
        """Queryable of the world: a scan, taken when asked for."""
        return f"{self.root}/body/{robot}/scan"

    def drive(self, robot: str) -> str:
        """The robot's newest drive order."""
        return f"{self.root}/body/{robot}/drive"

    def odometry(self, robot: str) -> str:
        """What the body tells its robot."""
        return f"{self.root}/body/{robot}/odometry"

    def muster(self, robot: str) -> str:
        """A robot's place in the lining up, to all robots."""
        return f"{self.root}/muster/{robot}"

    def mission(self) -> str:
        """Queryable of the world: what every robot is told before it starts."""
        return f"{self.root}/mission"

    def log(self, source: str) -> str:
        """Timeline entries of one source, to the recorder."""
        return f"{self.root}/log/{source}"

    def logged(self, source: str) -> str:
        """The recorder's acknowledgement to one source."""
        return f"{self.root}/logged/{source}"

    def fault(self, robot: str) -> str:
        """What is to go wrong at one robot, from the world: rules for messages, and how slow it is to be."""
        return f"{self.root}/fault/{robot}"

    def alive(self, source: str, incarnation: str) -> str:
        """Liveliness token; the incarnation tells a restarted source from its forerunner."""
        return f"{self.root}/alive/{source}/{incarnation}"

    def pulse(self, source: str) -> str:
        """Where a process speaks to nobody, to find out whether its session still can."""
        return f"{self.root}/pulse/{source}"

    def behind_root(self, key: str) -> str:
        """A key as it stands in the books: without what all keys of the run start with."""
        return key.removeprefix(self.root + "/")

    def part(self, key: str, index: int) -> str:
        """One chunk of a key, counted behind the root: of `…/link/r1/r2`, 1 is `r1`."""
        return self.behind_root(key).split("/")[index]
