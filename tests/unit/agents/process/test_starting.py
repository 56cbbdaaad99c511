"""Which robots a host starts when."""

from agents.process.starting import CONNECTING_MAX, Starting


def started(starting: Starting[str]) -> list[str]:
    """Start all that may be started now; a robot's process has the number of its name."""
    names = []
    while (name := starting.next()) is not None:
        starting.began(int(name[1:]))
        names.append(name)
    return names


def fleet(robots: int) -> Starting[str]:
    """Robots that wait for their first start."""
    starting = Starting[str]()
    for robot in range(robots):
        starting.wait(f"r{robot}")
    return starting


def test_few_robots_are_on_their_way_at_a_time() -> None:
    starting = fleet(CONNECTING_MAX + 3)
    assert started(starting) == [f"r{robot}" for robot in range(CONNECTING_MAX)]
    assert started(starting) == []


def test_the_next_starts_when_one_is_connected_or_has_ended() -> None:
    starting = fleet(CONNECTING_MAX + 3)
    started(starting)
    starting.arrived([2])
    starting.ended(5)
    assert started(starting) == [f"r{CONNECTING_MAX}", f"r{CONNECTING_MAX + 1}"]
    starting.ended(2)
    starting.arrived([5])
    assert started(starting) == [], "they had arrived before"


def test_a_robot_that_waits_already_is_started_once() -> None:
    starting = fleet(2)
    starting.wait("r1")
    assert started(starting) == ["r0", "r1"]
    starting.wait("r1")
    assert started(starting) == ["r1"], "it is started again"


def test_a_robot_that_is_forgotten_is_not_started_until_it_waits_again() -> None:
    starting = fleet(3)
    assert starting.forget("r1")
    assert not starting.forget("r1")
    assert started(starting) == ["r0", "r2"]
    starting.wait("r1")
    assert started(starting) == ["r1"]


def test_a_robot_that_is_held_is_not_started_until_it_is_let_go() -> None:
    starting = fleet(3)
    starting.hold("r1")
    starting.wait("r1")
    assert (started(starting), set(starting.held)) == (["r0", "r2"], {"r1"})
    starting.let_go("r1")
    assert (started(starting), set(starting.held)) == (["r1"], set())
    starting.hold("r1")
    assert set(starting.held) == set(), "it does not wait"


def test_a_robot_that_is_forgotten_is_not_held_when_it_waits_again() -> None:
    starting = fleet(2)
    starting.hold("r1")
    assert starting.forget("r1")
    starting.wait("r1")
    assert started(starting) == ["r0", "r1"]


def test_a_robot_is_started_again_after_its_former_process_has_ended() -> None:
    starting = fleet(2)
    started(starting)
    starting.wait("r1", after=[1])
    starting.arrived([1])
    starting.ended(0)
    assert started(starting) == []
    starting.ended(1)
    assert started(starting) == ["r1"]


def test_a_robot_is_held_also_while_its_former_process_ends() -> None:
    starting = fleet(2)
    started(starting)
    starting.wait("r1", after=[1])
    starting.hold("r1")
    starting.ended(1)
    assert started(starting) == []
    starting.let_go("r1")
    assert started(starting) == ["r1"]


def test_nobody_is_started_when_the_host_ends() -> None:
    starting = fleet(3)
    starting.hold("r1")
    starting.end()
    starting.let_go("r1")
    assert (started(starting), set(starting.held)) == ([], set())
