"""All figures of a run."""

from lab.figures.course import Course
from lab.figures.distances import NAME as DISTANCES
from lab.figures.distances import distances
from lab.figures.region import region
from lab.figures.steps import steps
from lab.figures.style import Chart, LeftOut
from lab.figures.traces import CLEARANCE, clearance, separation

WHY_LEFT_OUT = "the log does not say where obstacles were"


def charts_of(course: Course) -> list[Chart | LeftOut]:
    """The figures of a run, or why there is none."""
    return [region(course), steps(course), distances(course), clearance(course), separation(course)]


def charts_without_scenario(course: Course) -> list[Chart | LeftOut]:
    """What the entries alone say: paths and steps on no ground, and how far centres are apart."""
    drawn = [region(course), steps(course), separation(course, hulls_known=False)]
    return [*drawn, *(LeftOut(name, WHY_LEFT_OUT) for name in (DISTANCES, CLEARANCE))]
