"""The look of each robot: each has its own if there are few; with many, only leaders do."""

from clew.figures.style import GREY, HAIR_PT, LOOKS, Look
from clew.story.course import Course

OTHER = Look(GREY, ".", (0, ()), HAIR_PT)


def looks_of(course: Course) -> dict[int, tuple[Look, str | None]]:
    """The look of each robot by number, and its legend entry; None: it shares the entry of an earlier one."""
    robots = list(course.robots)
    leaders = dict.fromkeys(order[0] for _, order in course.orders)
    apart = robots if len(robots) <= len(LOOKS) else list(leaders)[: len(LOOKS)]
    others = [robot for robot in robots if robot not in apart]
    return {
        **{robot: (OTHER, "other robots" if robot == others[0] else None) for robot in others},
        **{robot: (look, f"robot {robot}") for robot, look in zip(apart, LOOKS, strict=False)},
    }
