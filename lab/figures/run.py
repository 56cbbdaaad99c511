"""All figures of a run."""

from lab.figures.course import Course
from lab.figures.distances import distances
from lab.figures.region import region
from lab.figures.steps import steps
from lab.figures.style import Chart, LeftOut
from lab.figures.traces import clearance, separation


def charts_of(course: Course) -> list[Chart | LeftOut]:
    """The figures of a run, or why there is none."""
    return [region(course), steps(course), distances(course), clearance(course), separation(course)]
