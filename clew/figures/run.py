"""All figures of a run."""

from clew.figures.distances import NAME as DISTANCES
from clew.figures.distances import distances
from clew.figures.region import region
from clew.figures.steps import steps
from clew.figures.style import Chart, LeftOut
from clew.figures.traces import CLEARANCE, clearance, separation
from clew.story.course import Course

WHY_LEFT_OUT = "the log does not say where obstacles were"


def charts_of(course: Course) -> list[Chart | LeftOut]:
    """The figures of a run, or the reason why there is none."""
    return [region(course), steps(course), distances(course), clearance(course), separation(course)]


def charts_without_scenario(course: Course) -> list[Chart | LeftOut]:
    """The figures from entries alone: paths and steps without ground, and distances between centres."""
    drawn = [region(course), steps(course), separation(course, hulls_known=False)]
    return [*drawn, *(LeftOut(name, WHY_LEFT_OUT) for name in (DISTANCES, CLEARANCE))]
