"""A campaign: many scenes, each rehearsed with several seeds, and a summary of all outcomes. A shell.

Rule 1: each outcome is appended to `episodes.jsonl` as soon as it exists. So an interrupted campaign can be
        continued, and loses only the episodes that were being played.
Rule 2: an outcome is valid as long as scene, seed, options and our own source that plays and judges
        (`PLAYED`) are the same to the byte.
Rule 3: `campaign.json` is written even if the user interrupts the campaign.
Rule 4: a folder has one campaign at a time, until its summary is written. A second one would play all that
        the first is playing.
"""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from dataclasses import replace as replace_fields
from hashlib import blake2b
from io import FileIO
from pathlib import Path

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from clew.campaign.classes import ClassFigures, by_class, sum_of_coverage
from clew.campaign.episode import (
    OUT_OF_TIME,
    SWARM,
    Episode,
    Outcome,
    Surprise,
    drawn_plan_path,
    drawn_replay,
)
from clew.campaign.executors.pool import outcomes_of
from clew.campaign.families import Figures, by_family, figures_of
from clew.campaign.scenes import Scene, check_widest, find_scenes, tighten
from clew.coverage.counters import uncovered
from clew.swarm.futures import draw_future, read_branches
from clew.swarm.plans import DRAWN
from clew.swarm.swarm import draw
from protocol.errors import UsageError
from protocol.faults import plan as plans
from protocol.files.opening import MADE_BYTES_MAX, read_bytes
from protocol.files.writing import check_ours, check_same, make_folder, open_private, write_whole
from protocol.law_files import copies, is_of_file, named
from protocol.root import ROOT
from world.record.recorder import EVENTS_FILE, held_alone

EPISODES_FILE, CAMPAIGN_FILE, SCENES_FOLDER = "episodes.jsonl", "campaign.json", "scenes"
DRAWN_FOLDER, DRAWN_MARK = "drawn", b'name = "swarm-'
SEEN_BY = 2000  # swarm episodes after which every coverage counter must have counted
_OURS = ("campaign", "coverage", "fields", "judge", "percentiles.py", "rehearsal", "swarm")
PLAYED = ("agents", "protocol", "world", *(f"clew/{each}" for each in _OURS))
"""The source that decides how an episode goes and how it is judged."""
CAMPAIGN_MARK = b'\n  "interrupted": '  # the second field of `campaign.json`, in every version of Clew


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """The request of the user."""

    roots: tuple[Path, ...]
    robots: int | None
    seeds: tuple[int, ...]
    law: str | None
    deployment: str | None
    time_s_max: float | None
    tight: float | None
    faults: str | None
    """A fault plan, `drawn` or `swarm`; with `swarm` there are no roots."""
    guided: bool = False
    """Whether each seed of a swarm is struck on its way (`clew.swarm.chain`)."""
    future: str | None = None
    """The branches of the future to play; None: the seed's own faults."""
    keep: bool
    """Whether to write every drawn world and plan, not only those that surprise."""
    jobs: int
    out: Path
    wall_s_max: float
    judge_every: int = 0
    """The second judge looks at every so many-th episode; 0: at none."""


class Campaign(Struct, frozen=True, kw_only=True):
    """`campaign.json`; docs/campaign.md explains each field."""

    ok: bool
    interrupted: bool
    roots: tuple[str, ...]
    robots: int | None
    seeds: tuple[int, ...]
    law: str | None
    deployment: str | None
    time_s_max: float | None
    tight: float | None
    faults: str | None
    guided: bool = False
    source_hash: str
    episodes_asked: int
    all: Figures
    families: dict[str, Figures]
    classes: dict[str, ClassFigures]
    coverage: dict[str, int]
    uncovered: tuple[str, ...]
    surprises: tuple[Outcome, ...]
    episodes: tuple[Outcome, ...]


Source = Callable[[Sequence[Episode], int], Iterator[Outcome]]
"""What plays episodes on so many processes."""
Watch = Callable[[int, int, int], None]
"""Gets the counts of done, requested and surprising episodes."""


def run(
    request: Request,
    watch: Watch,
    source: Source = outcomes_of,
    warn: Callable[[str], None] = lambda _: None,
) -> Campaign:
    """Play every episode without an outcome.

    Args:
        request: what is asked for.
        watch: is told after each episode.
        source: what plays them.
        warn: gets a line for each broken file, which is not played.

    Raises:
        UsageError: there is nothing to play; or the folder is not writable, has foreign files, or a
            campaign that is going on.
    """
    source_hash = hash_of_source()
    law = request.law and named(request.law, Path())
    request = replace_fields(request, law=law)
    try:
        kept = copies(law or "")
        _check_folder(request.out, kept)
        episodes = _with_judges(_episodes(request, source_hash, warn), request.judge_every)
        if not request.out.is_dir():
            make_folder(request.out)  # a refused campaign leaves no folder
        for name, text in kept.items():
            write_whole(request.out / name, text)
        with _held(request.out / EPISODES_FILE) as file:
            done, interrupted = _play(request, episodes, file, source, watch)
            campaign = _sum_up(request, episodes, done, source_hash, interrupted=interrupted)
            text = msgspec.json.format(msgspec.json.encode(campaign)) + b"\n"
            write_whole(request.out / CAMPAIGN_FILE, text)
    except OSError as error:
        where = error.filename or request.out
        raise UsageError(f"cannot write {where}: {error.strerror or error}") from error
    return campaign


def _check_folder(out: Path, kept: Mapping[str, bytes]) -> None:
    """Refuse a folder in which we would replace what is not ours.

    Raises:
        UsageError: it is a run's folder, or a file is there that is not ours and that we may replace.
    """
    if (out / EVENTS_FILE).exists():
        raise UsageError(f"{out}: is a run's folder, and a campaign never writes into one")
    check_ours(out / CAMPAIGN_FILE, CAMPAIGN_MARK)
    copied = {} if (out / EPISODES_FILE).exists() else kept  # earlier copies in a campaign's folder are ours
    for name, text in copied.items():
        check_same(out / name, text)
    for drawn in (out / DRAWN_FOLDER).glob("[0-9]*.toml"):
        check_ours(drawn, DRAWN_MARK)


def read_outcomes(path: Path) -> dict[str, Outcome]:
    """The outcomes in the file, by key, without torn lines and episodes that ran out of wall-clock time."""
    decoder = msgspec.json.Decoder(Outcome)
    outcomes: dict[str, Outcome] = {}
    for line in read_bytes(path, MADE_BYTES_MAX).split(b"\n") if path.exists() else ():
        try:
            outcome = decoder.decode(line)
        except msgspec.MsgspecError:
            continue  # torn or of another version: the episode is played again
        if outcome.ending != OUT_OF_TIME:
            outcomes[outcome.key] = outcome
    return outcomes


def _kept(episodes: Iterable[Episode], out: Path) -> dict[str, Outcome]:
    """The outcomes of these episodes in a folder, without those that are to be judged twice and were not."""
    judged = {episode.key: episode.judged for episode in episodes}
    return {
        key: outcome
        for key, outcome in read_outcomes(out / EPISODES_FILE).items()
        if key in judged and (outcome.judged or not judged[key])
    }


def hash_of_source() -> str:
    """A hash of our own source that plays and judges: outcomes of other source are not valid."""
    digest = blake2b(digest_size=16)
    paths = [ROOT / each for each in PLAYED]
    files = [path for each in paths for path in ([each] if each.is_file() else each.rglob("*.py"))]
    for path in sorted(files):
        digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def _episodes(request: Request, source_hash: str, warn: Callable[[str], None]) -> Iterator[Episode]:
    if request.faults == SWARM:
        for seed in request.seeds:
            episode = drawn_episode(seed, request.out, source_hash, wall_s_max=request.wall_s_max)
            if request.guided:
                yield replace(episode, key=f"{episode.key}-guided", branches="", guided=True)
            elif request.future is not None:
                yield replace(episode, key=f"{episode.key}-{request.future}", branches=request.future)
            else:
                yield episode
        return
    all_found, plan = find_scenes(request.roots, request.robots, warn), _plan_bytes(request.faults)
    is_ours = (request.out / EPISODES_FILE).exists()
    if request.tight is not None:
        check_widest(all_found)
    for found in all_found:
        scene = found
        if request.tight is not None:
            scene = tighten(
                found, request.tight, request.out / SCENES_FOLDER, request.deployment, is_ours=is_ours
            )
        for seed in request.seeds:
            yield Episode(
                key=_key(scene, seed, request, plan, source_hash),
                path=str(scene.path),
                family=scene.family,
                seed=seed,
                faults=request.faults,
                robots=scene.robots,
                robots_left_out=scene.robots_left_out,
                law=_law_kept(request),
                deployment=request.deployment,
                time_s_max=request.time_s_max,
                widest_path_radius_m=scene.widest_path_radius_m,
                wall_s_max=request.wall_s_max,
            )


def _law_kept(request: Request) -> str | None:
    """The law of all episodes, as a rehearsal takes it: of a file, it is that of the copy in our folder."""
    law = request.law
    return law if law is None or not is_of_file(law) else str(request.out / law)


def _with_judges(episodes: Iterable[Episode], every: int) -> list[Episode]:
    """The first of every so many episodes is judged twice."""
    return [
        replace(each, judged=True) if every and index % every == 0 else each
        for index, each in enumerate(episodes)
    ]


def drawn_episode(seed: int, out: Path, source_hash: str, *, wall_s_max: float) -> Episode:
    """The episode of a swarm seed, which also draws the world."""
    return Episode(
        key=blake2b(f"{SWARM}/{seed}/{source_hash}".encode(), digest_size=16).hexdigest(),
        path=str(out / DRAWN_FOLDER / f"{seed}.toml"),
        family=SWARM,
        seed=seed,
        faults=SWARM,
        robots=None,
        robots_left_out=0,
        law=None,
        deployment=None,
        time_s_max=None,
        widest_path_radius_m=None,
        wall_s_max=wall_s_max,
    )


def write_drawn(seed: int, path: Path, branches: str = "") -> None:
    """Write the world that the seed draws, with its fault plan, or that of its future, beside it."""
    swarm = draw_future(seed, read_branches(branches)) if branches else draw(seed)
    make_folder(path.parent)
    write_whole(path, swarm.world_text().encode())
    write_whole(Path(drawn_plan_path(str(path))), swarm.plan_text().encode())


def _with_drawn(outcome: Outcome, out: Path) -> Outcome:
    """Write the drawn world and plan; then a plain rehearsal of these files replays the episode."""
    future = f"@{outcome.branches}".replace(":", "-") if outcome.branches else ""
    path = out / DRAWN_FOLDER / f"{outcome.seed}{future}.toml"
    write_drawn(outcome.seed, path, outcome.branches)
    return replace(outcome, replay=drawn_replay(str(path), outcome.seed))


def _key(scene: Scene, seed: int, request: Request, plan: bytes, source_hash: str) -> str:
    law = request.law or scene.law
    options = [seed, scene.robots, law, request.deployment, request.time_s_max, plan]
    said = msgspec.json.encode([scene.family, scene.path.stem, *options, source_hash])
    return blake2b(scene.path.read_bytes() + said, digest_size=16).hexdigest()


def _plan_bytes(faults: str | None) -> bytes:
    """The content of the fault plan: the same plan under another name has the same outcome."""
    if faults is None or faults == DRAWN:  # our source decides what a seed draws, and is in the key
        return (faults or "").encode()
    return msgspec.json.encode(plans.load(faults, (DRAWN, SWARM)))


def _held(path: Path) -> FileIO:
    """The file of the outcomes, to append to. While it is open, no other campaign writes it (rule 4).

    Raises:
        UsageError: another campaign is going on there, or it cannot be opened.
        OSError: it cannot be read or written.
    """
    try:
        file = held_alone(open_private(path, "a"))
    except BlockingIOError as error:
        raise UsageError(f"{path.parent}: another campaign is going on there") from error
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror}") from error
    written = read_bytes(path, MADE_BYTES_MAX)
    if written and not written.endswith(b"\n"):  # torn
        file.write(b"\n")
    return file


def _play(
    request: Request, episodes: Sequence[Episode], file: FileIO, source: Source, watch: Watch
) -> tuple[dict[str, Outcome], bool]:
    """Play what has no outcome yet, and add each outcome to the file as it comes.

    Returns:
        All outcomes; and whether the user has interrupted the campaign.
    """
    done = _kept(episodes, request.out)
    left = [each for each in episodes if each.key not in done]
    surprises = sum(outcome.surprise is not Surprise.NONE for outcome in done.values())
    try:
        watch(len(done), len(episodes), surprises)
        for each in source(left, request.jobs):
            outcome = each
            if request.faults == SWARM and (request.keep or outcome.surprise is not Surprise.NONE):
                outcome = _with_drawn(outcome, request.out)
            file.write(msgspec.json.encode(outcome) + b"\n")
            done[outcome.key] = outcome
            surprises += outcome.surprise is not Surprise.NONE
            watch(len(done), len(episodes), surprises)
    except KeyboardInterrupt:
        return _kept(episodes, request.out) | done, True  # one may be in the file, and not in `done` yet
    return done, False


def _sum_up(
    request: Request,
    episodes: Sequence[Episode],
    done: dict[str, Outcome],
    source_hash: str,
    *,
    interrupted: bool,
) -> Campaign:
    outcomes = [done[episode.key] for episode in episodes if episode.key in done]
    surprises = tuple(outcome for outcome in outcomes if outcome.surprise is not Surprise.NONE)
    seen = sum_of_coverage(outcomes)
    unseen = tuple(uncovered(seen)) if request.faults == SWARM else ()
    return Campaign(
        ok=not surprises and not interrupted and not (unseen and len(outcomes) >= SEEN_BY),
        interrupted=interrupted,
        roots=tuple(map(str, request.roots)),
        robots=request.robots,
        seeds=request.seeds,
        law=request.law,
        deployment=request.deployment,
        time_s_max=request.time_s_max,
        tight=request.tight,
        faults=request.faults,
        guided=request.guided,
        source_hash=source_hash,
        episodes_asked=len(episodes),
        all=figures_of(outcomes),
        families={name: figures_of(family) for name, family in by_family(outcomes).items()},
        classes=by_class(outcomes),
        coverage=seen,
        uncovered=unseen,
        surprises=surprises,
        episodes=tuple(outcomes),
    )


def cores() -> int:
    """How many processes can work at the same time."""
    return len(os.sched_getaffinity(0))
