"""Queries of tests about the figures of a run."""

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from clew.figures.run import charts_of
from clew.figures.style import Chart
from clew.log import timeline
from clew.story.course import Course, course_of


def course(run: Path) -> Course:
    return course_of(timeline.read(run))


def chart(course: Course, name: str) -> Chart:
    (found,) = (each for each in charts_of(course) if each.name == name)
    assert isinstance(found, Chart)
    return found


def painted(chart: Chart) -> list[Axes]:
    figure = Figure()
    chart.paint(figure)
    return figure.axes
