from dataclasses import dataclass, field, replace

from clew.guided.cells import cells


@dataclass(frozen=True)
class Robot:
    robot: int
    state: str = "member"
    fence: tuple[int, int, int] = (3, 1, 2)
    role: str = ""
    drives: bool = False
    named: tuple[int, ...] = ()
    bound: tuple[int, ...] = ()
    silent: tuple[int, ...] = ()


@dataclass
class Faults:
    suffered: dict[int, str] = field(default_factory=dict)
    cuts: set[tuple[int, int]] = field(default_factory=set)

    def of(self, robot: int) -> str:
        return self.suffered.get(robot, "")

    def between(self, one: int, other: int) -> bool:
        return (one, other) in self.cuts


ONE, TWO = Robot(1, role="leader", bound=(1, 2)), Robot(2, role="tail", bound=(1, 2))
NONE = Faults()


def test_a_cell_does_not_tell_which_robots_are_in_it_nor_which_epoch() -> None:
    others = [
        Robot(7, role="tail", fence=(9, 5, 1), bound=(7, 4)),
        Robot(4, role="leader", fence=(9, 5, 1), bound=(7, 4)),
    ]
    assert set(cells([ONE, TWO], NONE)) == set(cells(others, NONE))


def test_each_thing_that_a_cell_tells_makes_another_cell() -> None:
    variants = [
        ([ONE, TWO], NONE),
        ([ONE, replace(TWO, state="aside")], NONE),
        ([ONE, replace(TWO, role="middle")], NONE),
        ([ONE, replace(TWO, drives=True)], NONE),
        ([ONE, replace(TWO, fence=(4, 1, 2))], NONE),
        ([ONE, replace(TWO, fence=(3, 1, 3))], NONE),
        ([ONE, replace(TWO, fence=(2, 1, 2))], NONE),
        ([ONE, replace(TWO, named=(1,))], NONE),
        ([ONE, replace(TWO, bound=(2,))], NONE),
        ([ONE, replace(TWO, silent=(1,))], NONE),
        ([ONE, TWO], Faults({2: "frozen"})),
        ([ONE, TWO], Faults(cuts={(1, 2)})),
        ([ONE, TWO], Faults(cuts={(2, 1)})),
    ]
    assert len({cell for fleet, faults in variants for cell in cells(fleet, faults)}) == len(variants)


def test_a_fleet_is_in_the_cells_of_all_its_pairs() -> None:
    three = replace(TWO, robot=3, state="aside")
    assert set(cells([ONE, TWO, three], NONE)) == {
        *cells([ONE, TWO], NONE),
        *cells([ONE, three], NONE),
        *cells([TWO, three], NONE),
    }


def test_cells_are_the_same_on_every_machine() -> None:
    assert list(cells([ONE, TWO], NONE)) == [0xFB39C1AC07E98D71]
