"""The things that an export draws, and when it draws them again."""

import math

import msgspec
import pytest
from shapely import LineString, Polygon

from clew.export.drawing import Colour, Disc, Stroke, Thing, capsule, outline
from clew.export.scene import BROKEN, CERTIFICATE, DEAD, GAP, ROBOT, Scene
from protocol.frames import Point
from protocol.path import Path
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    FaultInjected,
    PoseSampled,
    PromiseBroken,
    Record,
    RobotDied,
    RobotReturned,
    ScanServed,
    SeenGap,
    SeenObstacle,
    StepPlanned,
)
from tests.support.logs.logs import PAPER
from tests.support.strands import strand
from world.geometry.shapes import Circle, Ellipse

INK = Colour(0.0, 0.0, 0.0)
PLAN = StepPlanned(
    step=1,
    epoch=1,
    law="certified",
    x_m=0.0,
    y_m=0.0,
    obstacles=(
        SeenObstacle(tangent_1=Point(x_m=1.0, y_m=-2.0), tangent_2=Point(x_m=1.0, y_m=-1.0), chord_m=1.0),
        SeenObstacle(tangent_1=Point(x_m=1.0, y_m=1.0), tangent_2=Point(x_m=1.0, y_m=2.0), chord_m=1.0),
    ),
    gaps=(SeenGap(right=0, left=1, width_m=2.0, delta_rad=1.5, passable=True),),
    gap=0,
    heading_rad=0.0,
    length_m=1.0,
    target=Point(x_m=1.0, y_m=0.0),
    reach_m=2.0,
    promised_clearance_m=0.25,
    cost_to_go_m=None,
)


DIED = RobotDied(robot=2, silent_since_s=0.0)


def drawn(scene: Scene, record: Record, t_s: float = 0.0, source: str = "world") -> list[Thing]:
    return list(scene.hear(source, Entry(n=1, t_s=t_s, hlc="0/0", record=record)))


def formed(scene: Scene, epoch: int, *order: int) -> list[Thing]:
    """What is drawn anew when a strand forms."""
    return [
        thing for source, record in strand(epoch, *order) for thing in drawn(scene, record, source=source)
    ]


def strokes(thing: Thing, colour: Colour) -> list[Stroke]:
    return [mark for mark in thing.marks if isinstance(mark, Stroke) and mark.colour == colour]


def test_a_step_shows_the_chosen_gap_and_the_certified_ground() -> None:
    (thing,) = drawn(Scene(PAPER, {}), PLAN, source="r1")
    assert [stroke.points for stroke in strokes(thing, GAP)] == [((1.0, -1.0), (1.0, 1.0))]
    (promised,) = strokes(thing, CERTIFICATE)
    ground = Polygon(promised.points)
    swept = LineString([(0.0, 0.0), (1.0, 0.0)]).buffer(PAPER.fleet.robot_radius_m + 0.25)
    assert ground.symmetric_difference(swept).area < 0.01 * swept.area


def test_a_step_without_a_gap_or_a_promise_shows_neither() -> None:
    plain = msgspec.structs.replace(PLAN, gap=None, promised_clearance_m=None)
    (thing,) = drawn(Scene(PAPER, {}), plain, source="r1")
    assert strokes(thing, GAP) == strokes(thing, CERTIFICATE) == []


def test_an_authority_is_at_its_arc_length_of_the_strands_path() -> None:
    path = Path([Point(x_m=0.0, y_m=0.0), Point(x_m=2.0, y_m=0.0), Point(x_m=2.0, y_m=2.0)])
    grant = AuthorityGranted(to=2, epoch=1, authority_m=3.0)
    (thing,) = drawn(Scene(PAPER, {1: path}), grant, source="r1")
    assert thing.name == "authority/2"
    assert [mark.centre for mark in thing.marks if isinstance(mark, Disc)] == [(2.0, 1.0)]
    assert drawn(Scene(PAPER, {}), grant, source="r1") == []  # an epoch without a known path


def test_authorities_are_removed_with_their_strand() -> None:
    path = Path([Point(x_m=0.0, y_m=0.0), Point(x_m=2.0, y_m=0.0)])
    scene = Scene(PAPER, {1: path, 2: path})
    old = AuthorityGranted(to=2, epoch=1, authority_m=1.0)
    drawn(scene, old, source="r1")
    assert formed(scene, 2, 2, 3) == [Thing("authority/2", ())]
    assert drawn(scene, old, source="r1") == []  # it came late
    assert drawn(scene, AuthorityGranted(to=3, epoch=2, authority_m=1.0), source="r2") != []


def test_links_join_the_robots_of_the_newest_strand_ten_times_a_second() -> None:
    scene = Scene(PAPER, {})
    for robot in (1, 2, 3):
        drawn(scene, PoseSampled(robot=robot, x_m=float(robot), y_m=0.0, heading_rad=0.0))
    formed(scene, 2, 3, 1)
    formed(scene, 1, 1, 2, 3)  # it comes late
    nudge = RobotReturned(robot=3)
    assert "links" not in [thing.name for thing in drawn(scene, nudge, t_s=0.05)]
    (links,) = drawn(scene, nudge, t_s=0.1)
    assert [mark.points for mark in strokes(links, links.marks[0].colour)] == [((3.0, 0.0), (1.0, 0.0))]
    assert "links" not in [thing.name for thing in drawn(scene, nudge, t_s=0.3)]  # no robot has moved


@pytest.mark.parametrize(
    ("records", "colour"),
    [
        ((DIED,), DEAD),
        ((FaultInjected(fault="freeze", rule="a", process="r2"),), DEAD),
        ((DIED, RobotReturned(robot=2)), ROBOT),
        ((PromiseBroken(invariant="S1", robot=2, why="near"),), BROKEN),
    ],
)
def test_a_robots_colour_shows_its_state(records: tuple[Record, ...], colour: Colour) -> None:
    scene = Scene(PAPER, {})
    [*_, thing] = [thing for record in records for thing in drawn(scene, record)]
    assert (thing.name, thing.robot) == ("robot/2", 2)
    assert strokes(thing, colour) != []
    assert drawn(scene, ScanServed(robot=2, x_m=0.0, y_m=0.0, heading_rad=0.0, revolutions=1, hits=0)) == []


def test_outlines_match_their_shapes() -> None:
    disc = Polygon(outline(Circle(centre_m=(1.0, 2.0), radius_m=0.5), INK, at=(3.0, 0.0)).points)
    assert disc.centroid.coords[0] == pytest.approx((4.0, 2.0))
    assert disc.area == pytest.approx(math.pi * 0.25, rel=0.01)
    tall = Ellipse(centre_m=(0.0, 0.0), semi_axes_m=(2.0, 1.0), rotation_rad=math.pi / 2)
    assert Polygon(outline(tall, INK).points).bounds == pytest.approx((-1.0, -2.0, 1.0, 2.0), abs=0.01)
    assert Polygon(capsule((0.0, 0.0), (0.0, 1.0), 0.5, INK).points).bounds == pytest.approx(
        (-0.5, -0.5, 0.5, 1.5), abs=0.01
    )
