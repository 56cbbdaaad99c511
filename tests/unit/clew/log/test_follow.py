"""Following a timeline that is still being written: `clew/log/follow.py`."""

import asyncio
from contextlib import aclosing
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from clew.log import follow as following
from clew.log import vigil
from clew.log.follow import Follower, News, follow
from protocol.timeline import RobotReleased, RunEnded
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import AT_REST, HEADER, numbered, recorded
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE

LINES = numbered((*AT_REST[:-1], ("r1", RobotReleased()), ("r2", RobotReleased()), *AT_REST[-1:]))


@pytest.fixture(scope="module")
def text(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return (recorded(tmp_path_factory.mktemp("run"), LINES) / EVENTS_FILE).read_bytes()


def told(news: list[News]) -> list[object]:
    return [line for each in news for line in each.lines]


def play(sizes: list[bytes]) -> tuple[list[News], Follower]:
    """Looks at a file that holds each of these contents in turn."""
    follower = Follower(Path(EVENTS_FILE))
    return [follower.take(content[follower.whole_bytes :]) for content in sizes], follower


@given(cuts=st.lists(st.integers(0, 4000), max_size=20))
def test_each_entry_comes_once_and_complete_however_the_file_grows(cuts: list[int], text: bytes) -> None:
    news, follower = play([text[:cut] for cut in sorted(cuts)] + [text])
    assert told(news) == LINES
    assert [each.header for each in news if each.header] == [HEADER]
    assert not any(each.flaws for each in news)
    assert follower.ended
    assert follower.whole_bytes == len(text)


def test_a_torn_line_is_given_when_it_is_completed(text: bytes) -> None:
    news, _ = play([text[:-9], text])
    assert told(news[:1]) == LINES[:-1]
    assert told(news[1:]) == LINES[-1:]


def test_a_torn_line_that_a_resumed_world_cuts_off_is_forgotten(text: bytes) -> None:
    whole = text[: text[:-1].rindex(b"\n") + 1]
    news, follower = play([text[:-9], whole, whole, text])
    assert told(news) == LINES
    assert follower.close().flaws == ()


def test_a_line_that_stays_torn_is_a_flaw_with_its_number(text: bytes) -> None:
    _, follower = play([text[:-9]])
    assert follower.close().flaws == (
        f"line {len(LINES) + 1} is torn: dropped",
        "no run.ended: the world died before it could end the run",
    )


def test_an_unreadable_line_is_a_flaw_and_the_rest_is_given(text: bytes) -> None:
    first, *rest = text.splitlines(keepends=True)
    news, _ = play([b"".join([first, b'{"kind":"nonsense"}\n', *rest])])
    assert told(news) == LINES
    assert [flaw.partition(":")[0] for flaw in news[0].flaws] == ["line 2 cannot be read"]


def test_header_of_another_schema_is_a_flaw_and_the_rest_is_given(text: bytes) -> None:
    news, _ = play([text.replace(b"clew-timeline/1", b"clew-timeline/9", 1)])
    assert news[0].header is not None
    assert "clew-timeline/9" in news[0].flaws[0]
    assert told(news) == LINES


def test_first_line_that_is_no_header_is_a_flaw_and_the_rest_is_given(text: bytes) -> None:
    news, _ = play([b"{}\n" + text.partition(b"\n")[2]])
    assert news[0].flaws[0].startswith("line 1 is damaged")
    assert told(news) == LINES


def test_line_longer_than_what_is_read_at_once_comes(
    text: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(following, "READ_BYTES", 50)
    follower = Follower(path := tmp_path / EVENTS_FILE)
    path.write_bytes(text)
    news = []
    while follower.whole_bytes < len(text):
        news.append(following.look(follower))
        assert len(news) < len(text)
    assert told(news) == LINES


def test_a_file_that_shrinks_is_reported_and_read_on(text: bytes, tmp_path: Path) -> None:
    follower = Follower(path := tmp_path / EVENTS_FILE)
    path.write_bytes(text)
    following.look(follower)
    last = text[: text[:-1].rindex(b"\n") + 1]
    path.write_bytes(last)
    assert "no longer in the file" in following.look(follower).flaws[0]
    path.write_bytes(text)
    assert told([following.look(follower)]) == LINES[-1:]


async def test_run_is_awaited_followed_and_left_when_its_verdict_is_there(
    text: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(vigil, "QUIET_S", DEADLINE_S)  # it is not left because we write slowly
    run = tmp_path / "run"
    async with asyncio.timeout(DEADLINE_S), aclosing(follow(run)) as news:
        waiting = asyncio.ensure_future(anext(news))
        await asyncio.sleep(0)
        assert not waiting.done()
        run.mkdir()
        (run / EVENTS_FILE).write_bytes(text[:-9])
        first = await waiting
        with (run / EVENTS_FILE).open("ab") as file:
            file.write(text[-9:])
        second = await anext(news)
        (run / VERDICT_FILE).touch()
        assert [each async for each in news] == []
    assert told([first, second]) == LINES


async def test_log_without_a_verdict_is_left_some_time_after_its_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(vigil, "QUIET_S", 0.0)
    log = recorded(tmp_path, numbered((("world", RunEnded(reason="interrupted")),))) / EVENTS_FILE
    async with asyncio.timeout(DEADLINE_S):
        assert len([news async for news in follow(log)]) == 1
