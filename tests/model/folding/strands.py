"""How a strand lies: a model of its own, on a grid, of authority and of the rule that no strand folds back.

Robots stand on a path that leads from corner to corner of a grid, and drive one corner on at a time. What is
nearer than the diagonal of a cell is near. Places are numbers of corners along the path, leader first.

Rule 1 (authority): a robot grants the next corner when the way there is not near to all of the path from the
        granter on. Nothing is taken back.
Rule 2 (claim): a robot drives on if the way there is not near to the ground from the tail, as last heard, to
        what it has granted. To a straight part of it that it already is near to, it may just come no nearer.
Rule 3 (no strand folds back): when it forms, no two robots that follow each other are near, nor two legs that
        do not, nor an end of the strand and a leg but its own.

In the product rules 1 and 2 are `protocol/wire/authority.py`, and rule 3 is `agents/coordinating/folding.py`.
"""

from collections.abc import Iterator
from itertools import combinations, pairwise
from typing import NamedTuple

APART2 = 2  # the square of the diagonal

Corner = tuple[int, int]
Way = tuple[Corner, ...]
Places = tuple[int, ...]
Box = tuple[int, int, int, int]  # x, y from; x, y to: a corner, or a straight part of a way


class State(NamedTuple):
    """Where the robots are, and up to where each but the last has granted the path."""

    places: Places
    granted: Places


def box(*corners: Corner) -> Box:
    """The straight part of a way between two corners."""
    xs, ys = zip(*corners, strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def near(one: Box, other: Box) -> bool:
    """Whether two straight parts come near to each other."""
    x = max(0, one[0] - other[2], other[0] - one[2])
    y = max(0, one[1] - other[3], other[1] - one[3])
    return x * x + y * y < APART2


def straights(way: Way) -> list[Box]:
    """The straight parts of a way."""
    if len(way) == 1:
        return [box(*way)]
    steps = [(to_x - x, to_y - y) for (x, y), (to_x, to_y) in pairwise(way)]
    bends = [i for i, (one, other) in enumerate(pairwise(steps), start=1) if one != other]
    return [box(way[one], way[other]) for one, other in pairwise([0, *bends, len(way) - 1])]


def folds_back(path: Way, places: Places) -> bool:
    """Rule 3."""
    legs = [straights(path[behind : ahead + 1]) for ahead, behind in pairwise(places)]
    pairs = [(box(path[ahead]), box(path[behind])) for ahead, behind in pairwise(places)]
    apart = [(one, other) for i, one in enumerate(legs) for other in legs[i + 2 :]]
    pairs += [(each, its) for one, other in apart for each in one for its in other]
    pairs += [(box(path[places[0]]), each) for leg in legs[1:] for each in leg]
    pairs += [(box(path[places[-1]]), each) for leg in legs[:-1] for each in leg]
    return any(near(one, other) for one, other in pairs)


def are_near(path: Way, places: Places) -> bool:
    """What must not be: two robots are near to each other."""
    return any(near(box(path[one]), box(path[other])) for one, other in combinations(places, 2))


def grants(path: Way, granted: int, at: int) -> bool:
    """Rule 1: whether a robot at one corner grants the corner after those that it has granted."""
    way = box(*path[granted : granted + 2])
    return granted < at and not any(near(way, part) for part in straights(path[at:]))


def claims(path: Way, at: int, tail: int, granted: int) -> bool:
    """Rule 2: whether a robot may drive to the next corner."""
    (x, y), there = path[at], path[at + 1]
    for part in straights(path[tail : granted + 1]):
        if near(box(path[at]), part):
            to_x, to_y = min(max(x, part[0]), part[2]) - x, min(max(y, part[1]), part[3]) - y
            if (there[0] - x) * to_x + (there[1] - y) * to_y > 0:
                return False
        elif near(box(path[at], there), part):
            return False
    return True


def following(path: Way, state: State) -> Iterator[State]:
    """What may be next. News is late at will: a robot drives later, or knows an older place of the tail."""
    places, granted = state
    limits = (len(path) - 1, *granted)
    for rank, at in enumerate(places):
        is_tail = rank == len(granted)
        heard = range(places[-1] + 1)  # of the tail
        if at < limits[rank] and (is_tail or any(claims(path, at, tail, granted[rank]) for tail in heard)):
            yield State((*places[:rank], at + 1, *places[rank + 1 :]), granted)
        if not is_tail and grants(path, granted[rank], at):
            yield State(places, (*granted[:rank], granted[rank] + 1, *granted[rank + 1 :]))


def reached(path: Way, places: Places) -> set[State]:
    """All that can be, from a strand that has just formed: each robot is granted its place."""
    first = State(places, places[1:])
    states, new = {first}, [first]
    while new:
        after = {each for state in new for each in following(path, state)} - states
        states |= after
        new = list(after)
    return states


def ways(corners: int) -> Iterator[Way]:
    """All ways of so many corners that come to none again; of mirror images and turns, one."""

    def go_on(way: Way, *, bent: bool) -> Iterator[Way]:
        if len(way) == corners:
            yield way
            return
        for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            corner = way[-1][0] + x, way[-1][1] + y
            if corner not in way and (bent or y >= 0):
                yield from go_on((*way, corner), bent=bent or y != 0)

    yield from go_on(((0, 0), (1, 0)), bent=False)


def strands(robots: int, corners: int, *, onward: int) -> Iterator[tuple[Way, Places]]:
    """All strands on these ways, with up to so many corners ahead of the leader."""
    for path in ways(corners):
        for leader in range(corners - 1 - onward, corners):
            for between in combinations(range(1, leader), robots - 2):
                yield path, (leader, *reversed(between), 0)
