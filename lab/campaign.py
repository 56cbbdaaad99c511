"""A campaign: many scenes, each rehearsed with several seeds, and what came of all of them. A shell.

Rule 1: each outcome is a line of `episodes.jsonl`, written as it comes; so an interrupted campaign goes on
        where it was, and loses what was being played and nothing else.
Rule 2: an outcome counts as long as scene, seed, options and our own source are the same to the byte.
Rule 3: `campaign.json` is written whatever ends the campaign.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path

import msgspec
from msgspec import Struct

from lab.campaign_episode import OUT_OF_TIME, Episode, Outcome, Surprise
from lab.campaign_figures import Figures, by_family, figures_of
from lab.campaign_pool import outcomes_of
from lab.campaign_scenes import Scene, find_scenes, tighten
from protocol.errors import UsageError

EPISODES_FILE, CAMPAIGN_FILE, SCENES_FOLDER = "episodes.jsonl", "campaign.json", "scenes"
SOURCE = Path(__file__).parents[1]
PACKAGES = ("agents", "lab", "protocol", "world")


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """What the user asked for."""

    roots: tuple[Path, ...]
    robots: int | None
    seeds: tuple[int, ...]
    law: str | None
    deployment: str | None
    tight: float | None
    jobs: int
    out: Path
    wall_s_max: float


class Campaign(Struct, frozen=True, kw_only=True):
    """`campaign.json`; docs/campaign.md says what each field means."""

    ok: bool
    interrupted: bool
    roots: tuple[str, ...]
    robots: int | None
    seeds: tuple[int, ...]
    law: str | None
    deployment: str | None
    tight: float | None
    source_hash: str
    episodes_asked: int
    all: Figures
    families: dict[str, Figures]
    surprises: tuple[Outcome, ...]
    episodes: tuple[Outcome, ...]


def run(request: Request, watch: Callable[[int, int, int], None]) -> Campaign:
    """Play every episode that has not been played; `watch` hears how many are done, asked for, surprising.

    Raises:
        UsageError: there is nothing to play, or the folder cannot be written.
    """
    source_hash = hash_of_source()
    try:
        request.out.mkdir(parents=True, exist_ok=True)
        episodes = list(_episodes(request, source_hash))
        path = request.out / EPISODES_FILE
        keys = {episode.key for episode in episodes}
        done = {key: outcome for key, outcome in read_outcomes(path).items() if key in keys}
        interrupted = False
        try:
            _play(episodes, done, path, request.jobs, watch)
        except KeyboardInterrupt:
            interrupted = True
        campaign = _sum_up(request, episodes, done, source_hash, interrupted=interrupted)
        text = msgspec.json.format(msgspec.json.encode(campaign)) + b"\n"
        (request.out / CAMPAIGN_FILE).write_bytes(text)
    except OSError as error:
        raise UsageError(f"cannot write a campaign into {request.out}: {error.strerror or error}") from error
    return campaign


def read_outcomes(path: Path) -> dict[str, Outcome]:
    """What has been played, by key. A torn line has not, nor has what only lacked time."""
    decoder = msgspec.json.Decoder(Outcome)
    outcomes: dict[str, Outcome] = {}
    for line in path.read_bytes().split(b"\n") if path.exists() else ():
        try:
            outcome = decoder.decode(line)
        except msgspec.MsgspecError:
            continue  # torn, or of another version: either way it is played again
        if outcome.ending != OUT_OF_TIME:
            outcomes[outcome.key] = outcome
    return outcomes


def hash_of_source() -> str:
    """A hash of our own source: results of other code are not ours."""
    digest = blake2b(digest_size=16)
    for path in sorted(path for package in PACKAGES for path in (SOURCE / package).rglob("*.py")):
        digest.update(path.relative_to(SOURCE).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def _episodes(request: Request, source_hash: str) -> Iterator[Episode]:
    for found in find_scenes(request.roots, request.robots):
        scene = found
        if request.tight is not None:
            scene = tighten(found, request.tight, request.out / SCENES_FOLDER, request.deployment)
        for seed in request.seeds:
            yield Episode(
                key=_key(scene, seed, request, source_hash),
                path=str(scene.path),
                family=scene.family,
                seed=seed,
                robots=scene.robots,
                robots_left_out=scene.robots_left_out,
                law=request.law,
                deployment=request.deployment,
                widest_path_radius_m=scene.widest_path_radius_m,
                wall_s_max=request.wall_s_max,
            )


def _key(scene: Scene, seed: int, request: Request, source_hash: str) -> str:
    options = [seed, scene.robots, request.law, request.deployment]
    said = msgspec.json.encode([scene.family, scene.path.stem, *options, source_hash])
    return blake2b(scene.path.read_bytes() + said, digest_size=16).hexdigest()


def _play(
    episodes: Sequence[Episode],
    done: dict[str, Outcome],
    path: Path,
    jobs: int,
    watch: Callable[[int, int, int], None],
) -> None:
    """Play what is not done, line by line into the file, and into `done`."""
    torn = path.exists() and not path.read_bytes().endswith(b"\n")
    surprises = sum(outcome.surprise is not Surprise.NONE for outcome in done.values())
    watch(len(done), len(episodes), surprises)
    with path.open("ab", buffering=0) as file:
        if torn:
            file.write(b"\n")
        for outcome in outcomes_of([each for each in episodes if each.key not in done], jobs):
            file.write(msgspec.json.encode(outcome) + b"\n")
            done[outcome.key] = outcome
            surprises += outcome.surprise is not Surprise.NONE
            watch(len(done), len(episodes), surprises)


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
    return Campaign(
        ok=not surprises and not interrupted,
        interrupted=interrupted,
        roots=tuple(map(str, request.roots)),
        robots=request.robots,
        seeds=request.seeds,
        law=request.law,
        deployment=request.deployment,
        tight=request.tight,
        source_hash=source_hash,
        episodes_asked=len(episodes),
        all=figures_of(outcomes),
        families={name: figures_of(family) for name, family in by_family(outcomes).items()},
        surprises=surprises,
        episodes=tuple(outcomes),
    )


def cores() -> int:
    """How many processes this one may have at work at once."""
    return len(os.sched_getaffinity(0))
