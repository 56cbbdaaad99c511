"""Schedules that a reviewer found, by which a promise was broken or a fleet waited for nothing."""

import pytest
from msgspec.structs import replace

from agents.commands import Command, Note, Put, Say
from agents.coordinating.agreeing import Intent
from agents.coordinating.coordinator import Coordinator
from agents.coordinating.phases import Phase
from agents.liveness.suspicion import Suspicion
from agents.liveness.timing import Timing
from clew.explore.moments import WORLD
from clew.explore.setting import SCATTERED, Setting
from protocol.fence import Cause, Epoch, Fence, May, Turn
from protocol.frames import Point, Pose
from protocol.timeline import StrandFormed
from protocol.wire.messages import Drive, Odometry, Scan
from protocol.wire.messages import Phase as RunPhase
from protocol.wire.view import Answer, Counters, Former, Look, Report
from tests.support.stages.one_step import under
from tests.support.stages.view_stage import Post, ViewStage, in_turn, of
from world.scenario.scenario import Scenario

# --- a body beside a driven leg, where obstacles move ---------------------------------------------------


def beside_a_wall(obstacle_speed_mps_max: float) -> Scenario:
    """Robots 1 and 2 on one side of a wall of posts; robot 3 comes round its end, across their leg."""
    posts = [(0.9 + 0.12 * index, 3.55) for index in range(12)]
    posts += [(0.85, 2.4 + 0.12 * index) for index in range(10)]
    setting = Setting(
        name="beside-a-wall",
        about="a robot comes round a wall, across the leg of the others",
        places=((2.0, 3.0, 0.0), (1.55, 3.0, 0.0), (2.2, 4.3, 0.0)),
        goal_m=(3.3, 3.0),
        obstacles=tuple((x_m, y_m, 0.06) for x_m, y_m in posts),
        obstacle_speed_mps_max=obstacle_speed_mps_max,
        size_m=(10.0, 6.0),
        separation_m=0.2,
        link_length_m_max=1.4,
    )
    return setting.scenario()


@pytest.mark.parametrize("obstacle_speed_mps_max", [0.0, 0.1])
def test_a_robot_that_drives_a_driven_leg_keeps_off_a_body_that_died_beside_it(
    obstacle_speed_mps_max: float,
) -> None:
    """V3 of the design, where a watch replaces looking: the stage asks for S2, also of ordered ground."""
    stage = ViewStage.begun(scenario=beside_a_wall(obstacle_speed_mps_max))
    stage.kill(3)
    stage.run(lambda: stage.fence.may is May.ALL)
    stage.lose(lambda post: of(Drive, sender=2)(post) and post.thing.target is not None)
    stage.run(lambda: stage.place(1)[0] > 2.9)
    stage.pass_s(1.0)
    stage.start(3)
    stage.run(lambda: stage.fence.may is May.ONE and stage.fence.robot == 3)
    stage.run(lambda: stage.place(3)[1] < 3.5)
    stage.kill(3)
    stage.heal()
    stage.run(lambda: stage.fence.may is May.ALL)
    stage.pass_s(5.0)


# --- a leg that counts as driven to where the robot ahead stood before its turn -------------------------

MISSION = under("certified", robots=3, robot_radius_m=0.1, separation_m=0.1, goal=Point(x_m=9.0, y_m=0.0))
LAST = Epoch(generation=1, robot=3, life=13)
EPOCH = Epoch(generation=2, robot=1, life=11)
LIVES = {1: 11, 2: 12, 3: 13}
AT = {
    1: Pose(x_m=1.0, y_m=0.0, heading_rad=0.0),
    2: Pose(x_m=2.0, y_m=0.0, heading_rad=0.0),
    3: Pose(x_m=1.6, y_m=0.45, heading_rad=0.0),
}
MOVED = Pose(x_m=2.0, y_m=-0.9, heading_rad=0.0)
FORMERS: dict[int, tuple[Former, ...]] = {
    1: (Former(epoch=LAST, rank=1, s_m=0.0, at=Point(x_m=0.0, y_m=0.0)),),
    2: (Former(epoch=LAST, rank=0, s_m=1.0, at=Point(x_m=1.0, y_m=0.0)),),
    3: (),
}


class Fleet:
    """A coordinator, and what three robots report to it; a put is told at once."""

    def __init__(self) -> None:
        timing = Timing.of(MISSION)
        self.now_s, self.fence, self.told = 0.0, Fence(epoch=EPOCH), 0
        self.formed: StrandFormed | None = None
        self.suspicion = Suspicion(timing)
        for robot in (0, 1, 2, 3):
            self.suspicion.presence.come(robot, "a", 0.0)
        self.coordinator = Coordinator(
            EPOCH,
            mission=MISSION,
            timing=timing,
            suspicion=self.suspicion,
            intent=Intent(Cause.NO_WAY, 2),
            now_s=0.0,
        )
        led = Counters(last_to_lead=(2, 1))
        self.reports = {
            robot: Report(
                epoch=EPOCH,
                life=LIVES[robot],
                number=0,
                turn=0,
                place=AT[robot],
                formers=FORMERS[robot],
                counters=led,
                counted=LAST,
            )
            for robot in AT
        }
        for robot in AT:
            self.say(robot)

    def say(self, robot: int, **news: object) -> None:
        number = self.reports[robot].number + 1
        self.reports[robot] = replace(self.reports[robot], **{"number": number} | news)
        self.coordinator.hear(robot, self.reports[robot], self.now_s)

    def step(self) -> None:
        self.now_s, self.told = round(self.now_s + 0.1, 6), self.told + 1
        self.suspicion.live(self.now_s)
        odometry = Odometry(
            n=self.told,
            t_s=self.now_s,
            pose=AT[1],
            moving=False,
            finished=0,
            fence=self.fence,
            phase=RunPhase.RUNNING,
        )
        for command in self.coordinator.act(odometry, self.now_s):
            self._obey(command)

    def _obey(self, command: Command) -> None:
        match command:
            case Put(Turn(fence=fence)) if fence.turn == self.fence.turn + 1:
                self.fence = fence
            case Note(StrandFormed() as formed):
                self.formed = formed
            case Say(robot, Answer() as answer) if (self.fence.may, self.fence.robot) != (May.ONE, robot):
                if answer.question is not None:
                    self._look(robot, answer)
                elif self.reports[robot].turn <= answer.after_turn > 0:
                    self.say(robot, turn=self.fence.turn)

    def _look(self, robot: int, answer: Answer) -> None:
        """Only robot 1 knows its leg: to where robot 2 stood in the last strand."""
        question = answer.question
        assert question is not None
        knows = robot == 1 and question.formers == FORMERS[2]
        way = tuple(Point(x_m=AT[each].x_m, y_m=AT[each].y_m) for each in (1, 2)) if knows else ()
        self.say(robot, look=Look(number=question.number, clear=knows, way=way))


def test_a_leg_to_a_robot_that_has_moved_in_its_turn_does_not_count_as_driven() -> None:
    fleet = Fleet()
    while (fleet.fence.may, fleet.fence.robot) != (May.ONE, 2):  # robot 3 leads, and robot 2 is to join
        fleet.step()
        robot = fleet.fence.robot
        if fleet.fence.may is May.ONE and robot != 2:
            fleet.say(robot, ended=fleet.fence.turn, turn=fleet.fence.turn)
    turn = fleet.fence.turn
    fleet.suspicion.presence.go(3, "a", fleet.now_s)  # robot 3 dies; the draft begins again in that turn
    for _ in range(8):
        fleet.step()
    assert fleet.coordinator.phase is not Phase.GATHERING or fleet.fence.may is not May.ONE
    if fleet.formed is None:
        fleet.say(2, place=MOVED, formers=(), ended=turn, placed=True, turn=fleet.fence.turn)
    for _ in range(80):
        fleet.step()
    assert fleet.formed is not None
    assert fleet.reports[2].place == AT[2] or fleet.formed.driven == (False, False)


# --- turns and lives ------------------------------------------------------------------------------------


def test_a_robot_that_has_the_turn_twice_and_misses_what_was_between_drives_in_the_second() -> None:
    stage = in_turn(2, 3, SCATTERED)
    turn, epoch = stage.fence.turn, stage.fence.epoch
    stage.lose(of(Odometry, receiver=3))
    stage.post(Post(2, WORLD, 10**6, Turn(fence=Fence(epoch=epoch, turn=turn + 1))))
    stage.run(lambda: stage.fence.turn == turn + 2)
    assert (stage.fence.may, stage.fence.robot) == (May.ONE, 3)
    stage.heal()
    stage.run(lambda: stage.fence.may is May.ALL, s_max=5.0)
    assert stage.formed is not None
    assert 3 in stage.formed.order


def test_a_coordinator_that_can_do_nothing_in_its_own_turn_leaves_itself_out() -> None:
    """Else it gives itself one turn after the other, and nobody moves for as long as it sees nothing."""
    stage = in_turn(3, 3, SCATTERED)
    stage.lose(of(Scan, receiver=3))
    stage.run(lambda: stage.fence.may is May.ALL, s_max=40.0)
    assert stage.formed is not None
    assert 3 not in stage.formed.order
    stage.heal()
    stage.run(lambda: stage.fence.may is not May.ALL, s_max=15.0)
    stage.run(lambda: stage.fence.may is May.ALL, s_max=15.0)
    assert 3 in stage.formed.order


def test_a_late_report_of_a_robots_older_life_replaces_no_newer_one() -> None:
    stage = in_turn(2, 3, SCATTERED)
    old, epoch = stage.sent(of(Report, sender=3, epoch=stage.fence.epoch))[0], stage.fence.epoch
    life, places = old.thing.life, len(stage.sent(of(Report, sender=3)))
    stage.replace(3)
    stage.run(lambda: any(post.thing.life != life for post in stage.sent(of(Report, sender=3))[places:]))
    stage.run(lambda: not stage.mail)
    stage.hold(of(Report, sender=3))  # of the new life, from here on
    first = len(stage.posted)
    stage.deliver(old)
    stage.pass_s(0.3)
    answers = [post for post in stage.posted[first:] if of(Answer, receiver=3, epoch=epoch)(post)]
    assert all(post.thing.life != life for post in answers)
