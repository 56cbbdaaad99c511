"""How `clew view` watches a run, feeds its pages and answers requests, without a socket."""

from http import HTTPStatus
from pathlib import Path

import h11
import pytest

from clew.log import vigil
from clew.log.follow import News
from clew.page.serve.feed import ANEW, Feed
from clew.page.serve.pages import policy, site
from clew.page.serve.site import Document, Site, Telling, answer, head, hosts_of
from clew.page.serve.watch import Began, Over, Seen, Watch
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import AT_REST, numbered, recorded
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE

LINES = numbered(AT_REST)


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return recorded(tmp_path / "run", LINES)


@pytest.fixture(autouse=True)
def no_run_is_over_because_a_test_writes_slowly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vigil, "QUIET_S", DEADLINE_S)


def numbers(seen: list[Seen]) -> list[int]:
    return [entry.n for each in seen if isinstance(each, News) for _, entry in each.lines]


def test_a_run_that_begins_later_is_watched_from_its_start(tmp_path: Path) -> None:
    watch = Watch(tmp_path / "run")
    assert watch.look() == []
    recorded(tmp_path / "run", LINES)
    began, news = watch.look()
    assert began == Began(tmp_path / "run" / EVENTS_FILE)
    assert numbers([news]) == [entry.n for _, entry in LINES]
    assert watch.look() == []


def test_a_link_that_comes_while_it_is_looked_for_is_a_run_at_the_next_look(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, latest = recorded(tmp_path / "first", LINES), tmp_path / "latest"
    is_dir = Path.is_dir

    def link_comes_after(place: Path) -> bool:
        answer = is_dir(place)
        if not latest.is_symlink():
            latest.symlink_to(run)
        return answer

    monkeypatch.setattr(Path, "is_dir", link_comes_after)
    watch = Watch(latest)
    assert watch.look() == []
    latest.is_dir()
    assert watch.look()[0] == Began(run / EVENTS_FILE)


def test_lines_cut_off_by_a_resumed_world_are_never_sent_and_its_new_lines_are(run: Path) -> None:
    events = run / EVENTS_FILE
    whole = events.read_bytes()
    *_, last = whole.splitlines(keepends=True)
    events.write_bytes(whole[:-10])
    watch = Watch(run)
    assert len(numbers(watch.look())) == len(LINES) - 1
    with events.open("r+b") as file:
        file.truncate(len(whole) - len(last))
    assert watch.look() == []
    with events.open("ab") as file:
        file.write(last)
    assert numbers(watch.look()) == [LINES[-1][1].n]


def test_a_changed_link_to_latest_is_a_new_run_sent_from_its_start(tmp_path: Path, run: Path) -> None:
    latest = tmp_path / "latest"
    latest.symlink_to(run)
    watch = Watch(latest)
    watch.look()
    other = recorded(tmp_path / "other", LINES[:2])
    latest.unlink()
    assert watch.look() == []
    latest.symlink_to(other)
    seen = watch.look()
    assert seen[0] == Began(other / EVENTS_FILE)
    assert numbers(seen) == [1, 2]


def test_the_verdict_is_sent_when_it_is_complete_and_after_all_entries(run: Path) -> None:
    watch = Watch(run)
    (run / VERDICT_FILE).write_text('{"ok": tr', encoding="utf-8")
    assert numbers(watch.look())
    assert watch.look() == []
    (run / VERDICT_FILE).write_text('{"ok": true}', encoding="utf-8")
    assert watch.look() == [Over({"ok": True}, ())]
    assert watch.look() == []


def test_a_torn_end_of_the_log_is_reported_with_the_verdict(run: Path) -> None:
    with (run / EVENTS_FILE).open("ab") as file:
        file.write(b'{"t_s":')
    (run / VERDICT_FILE).write_text("{}", encoding="utf-8")
    watch = Watch(run)
    watch.look()
    (judged,) = watch.look()
    assert isinstance(judged, Over)
    assert any("is torn" in flaw for flaw in judged.flaws)


def heard(feed: Feed, newest_id: str | None) -> list[bytes]:
    """The messages that a page receives after this id."""
    place, messages = feed.place(newest_id), list[bytes]()
    while (told := feed.next(place)) is not None:
        message, place = told
        messages.append(message)
    return messages


def test_a_late_page_receives_everything_and_a_returning_page_continues() -> None:
    feed = Feed()
    feed.begin("a1")
    for text in (b"one", b"two", b"three"):
        feed.tell(text)
    everything = [b"id: a1-1\ndata: one\n\n", b"id: a1-2\ndata: two\n\n", b"id: a1-3\ndata: three\n\n"]
    assert heard(feed, None) == everything
    assert heard(feed, "a1-2") == everything[2:]
    assert heard(feed, "a1-3") == []


@pytest.mark.parametrize("nonsense", ["", "7", "a1-", "-3", "a1--1", "zz-1", "a1-1\n", "a1-99999999999"])
def test_a_page_with_a_foreign_id_begins_at_the_start(nonsense: str) -> None:
    feed = Feed()
    feed.begin("a1")
    feed.tell(b"one")
    assert heard(feed, nonsense) == [b"id: a1-1\ndata: one\n\n"]


def test_a_page_that_shows_another_run_is_told_to_restart() -> None:
    feed = Feed()
    waiting = feed.place(None)
    feed.begin("a1")
    feed.tell(b"one")
    told = feed.next(waiting)
    assert told is not None
    message, place = told
    assert message == b"id: a1-1\ndata: one\n\n"
    feed.begin("b2")
    assert feed.next(place) == (ANEW, feed.place(None))
    assert heard(feed, "a1-1") == [ANEW]


HOSTS = hosts_of(8123)
SITE: Site = {"/": Document(b"page"), "/events/0": 0}


def asked(path: str, method: str = "GET", **headers: str) -> Document | Telling:
    named = {"host": "127.0.0.1:8123"} | {name.replace("_", "-"): value for name, value in headers.items()}
    return answer(h11.Request(method=method, target=path, headers=list(named.items())), SITE, HOSTS)


def test_a_page_continues_after_the_last_message_that_it_has_seen() -> None:
    assert asked("/") == SITE["/"]
    assert asked("/?theme=dark") == SITE["/"]
    assert asked("/events/0") == Telling(0, None)
    assert asked("/events/0", last_event_id="a1-7") == Telling(0, "a1-7")


@pytest.mark.parametrize(
    ("path", "method", "host", "status"),
    [
        ("/", "GET", "evil.example:8123", HTTPStatus.MISDIRECTED_REQUEST),
        ("/", "GET", "127.0.0.1", HTTPStatus.MISDIRECTED_REQUEST),
        ("/", "GET", "127.0.0.1:8124", HTTPStatus.MISDIRECTED_REQUEST),
        ("/events/0", "GET", "127.0.0.1:8123.evil.example", HTTPStatus.MISDIRECTED_REQUEST),
        ("/", "POST", "127.0.0.1:8123", HTTPStatus.METHOD_NOT_ALLOWED),
        ("/", "HEAD", "127.0.0.1:8123", HTTPStatus.METHOD_NOT_ALLOWED),
        ("/events/0", "PUT", "localhost:8123", HTTPStatus.METHOD_NOT_ALLOWED),
        ("/events/1", "GET", "localhost:8123", HTTPStatus.NOT_FOUND),
        ("/../etc/passwd", "GET", "localhost:8123", HTTPStatus.NOT_FOUND),
        ("/%2e%2e/events.jsonl", "GET", "localhost:8123", HTTPStatus.NOT_FOUND),
        ("http://127.0.0.1:8123/", "GET", "localhost:8123", HTTPStatus.NOT_FOUND),
    ],
)
def test_all_other_requests_are_refused(path: str, method: str, host: str, status: HTTPStatus) -> None:
    said = asked(path, method, host=host)
    assert isinstance(said, Document)
    assert said.status == status


@pytest.mark.parametrize("path", ["/", "/events/0"])
@pytest.mark.parametrize(
    "site", ["cross-site", "same-site"]
)  # a server on another port counts as the same site
def test_requests_from_pages_of_another_origin_are_refused(path: str, site: str) -> None:
    said = asked(path, sec_fetch_site=site, sec_fetch_mode="no-cors", sec_fetch_dest="script")
    assert isinstance(said, Document)
    assert said.status == HTTPStatus.FORBIDDEN
    framed = asked(path, sec_fetch_site=site, sec_fetch_mode="navigate", sec_fetch_dest="iframe")
    assert isinstance(framed, Document)
    assert framed.status == HTTPStatus.FORBIDDEN


def test_requests_from_our_page_the_user_and_any_link_are_answered() -> None:
    assert asked("/events/0", sec_fetch_site="same-origin", sec_fetch_mode="cors") == Telling(0, None)
    assert asked("/", sec_fetch_site="none", sec_fetch_mode="navigate") == SITE["/"]
    linked = asked("/", sec_fetch_site="cross-site", sec_fetch_mode="navigate", sec_fetch_dest="document")
    assert linked == SITE["/"]


@pytest.mark.parametrize("path", ["/", "/events/0", "/nothing"])
def test_another_origin_cannot_read_any_answer(path: str) -> None:
    said = dict(head(asked(path)).headers)
    assert said[b"cross-origin-resource-policy"] == b"same-origin"
    assert said[b"x-content-type-options"] == b"nosniff"
    assert not [name for name in said if name.startswith(b"access-control-")]


def test_only_the_pages_own_scripts_may_run_in_it() -> None:
    page = site(2)["/"]
    assert isinstance(page, Document)
    assert "script-src 'sha256-" in page.policy
    assert "connect-src 'self'" in page.policy
    assert {"default-src 'none'", "base-uri 'none'", "frame-ancestors 'none'"} <= set(page.policy.split("; "))
    assert "'unsafe-eval'" not in page.policy
    assert policy("<script>1</script>") != policy("<script>2</script>")
    (scripts,) = [part for part in page.policy.split("; ") if part.startswith("script-src")]
    assert "unsafe" not in scripts
