"""A promise that no robot keeps, so that searches have something to find."""

import pytest
from msgspec.structs import replace

from protocol.timeline import PromiseBroken, RobotStarted
from world import core
from world.judge import judgement as judgements
from world.judge.evidence import Evidence
from world.judge.judgement import Breach, Judgement, judge_evidence
from world.scenario.scenario import Scenario


def break_at_restarts(monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on a promise is broken once a robot has been started again."""

    def judged(scenario: Scenario, evidence: Evidence) -> Judgement:
        judgement = judge_evidence(scenario, evidence)
        starts = [
            (t_s, robot)
            for robot, told in evidence.told.items()
            for t_s, record in told
            if isinstance(record, RobotStarted)
        ]
        again = sorted(starts)[scenario.fleet.robots :]
        broken = [
            Breach(t_s=t_s, broken=PromiseBroken(invariant="P1", robot=robot, why="it is started again"))
            for t_s, robot in again
        ]
        return replace(judgement, breaches=(*judgement.breaches, *broken))

    monkeypatch.setattr(core, "judge_evidence", judged)
    monkeypatch.setattr(judgements, "judge_evidence", judged)
