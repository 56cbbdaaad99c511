"""News goes down a strand of real cores at once; chains of real processes pass it on."""

import json

import pytest

from agents.commands import Tell
from agents.events import LinkHeard
from clew.bench.hop.chain import Chain, figures
from clew.bench.hop.strand import Strand
from protocol.wire.messages import AheadState, BehindState
from tests.support.campaigns import clew

NUMBER = 1000


def test_each_robot_tells_the_one_behind_the_news_at_once_and_acknowledges_it() -> None:
    strand = Strand(4)
    for number in (NUMBER, NUMBER + 1):
        news = strand.news()
        for robot in (2, 3, 4):
            commands = strand.cores[robot].handle(LinkHeard(robot - 1, number, news), strand.now_s)
            told = {each.robot: each.state for each in commands if isinstance(each, Tell)}
            acknowledged = told.pop(robot - 1)
            assert isinstance(acknowledged, BehindState)
            assert acknowledged.vertices == strand.vertices == news.vertices
            if robot < 4:
                forwarded = told.pop(robot + 1)
                assert isinstance(forwarded, AheadState)
                news = forwarded
            assert told == {}


def test_news_that_was_lost_is_told_again_until_it_is_confirmed() -> None:
    strand = Strand(3)
    begun = strand.vertices
    strand.news()
    news = strand.news()
    commands = strand.cores[2].handle(LinkHeard(1, NUMBER, news), strand.now_s)
    assert len([each for each in commands if isinstance(each, Tell)]) == 2
    assert (news.path_from, len(news.path)) == (begun - 1, 3)
    strand.confirm(news.vertices)
    assert len(strand.news().path) == 2


def chain(kind: str, *took_us: float, cpu_us: float) -> Chain:
    return Chain(kind=kind, robots=5, took_us=took_us, lost=0, cpu_us=cpu_us)


def test_a_chain_is_compared_with_bare_relays_of_its_repeat() -> None:
    repeats = [
        [
            chain("stack", 800.0, 1000.0, 9000.0, cpu_us=300.0 * slow),
            chain("asyncio", *[400.0, 500.0, 600.0], cpu_us=100.0 * slow),
            chain("callback", 200.0, cpu_us=50.0 * slow),
        ]
        for slow in (1.0, 3.0)
    ]
    median, p99, cpu = figures(repeats)
    assert (median.measured.median, median.met) == (250.0, False)  # us a hop, of which there are four
    assert [(base.name, base.ratio.median) for base in median.baselines] == [
        ("asyncio relay", 2.0),
        ("callback relay", 5.0),
    ]
    assert (p99.measured.median, p99.met) == (9000.0, None)
    assert (cpu.measured.most, cpu.baselines[0].ratio.most) == (900.0, 3.0)


@pytest.mark.long
@pytest.mark.processes
def test_chains_of_real_processes_pass_news_on() -> None:
    told = clew("bench", "hop", "3", "--runs", "1", "--news", "3", "--json")
    assert told.exit_code == 0, told.output
    result = json.loads(told.stdout)
    assert [each["kind"] for each in result["details"]] == ["stack", "asyncio", "callback"]
    assert all(len(each["took_us"]) + each["lost"] == 3 for each in result["details"])
    assert all(figure["measured"]["median"] > 0.0 for figure in result["figures"])
