"""What chains of relays measured, and the figures of them. Pure."""

from collections.abc import Callable, Sequence

from msgspec import Struct

from clew.bench.result import Aim, Figure, figure
from clew.percentiles import percentile

RATIO_AIM = 1.3  # of the asyncio relay
STACK, BARE = "stack", ("asyncio", "callback")
NAMES = {"asyncio": "asyncio relay", "callback": "callback relay"}


class Chain(Struct, frozen=True, kw_only=True):
    """One repeat with one kind of relay."""

    kind: str
    robots: int
    took_us: tuple[float, ...]
    """From the leader's put to the last robot's reaction, of each piece of news that came through."""
    lost: int
    cpu_us: float
    """CPU time of a relay for a piece of news, with all that follows from it and all that goes on beside."""


def figures(repeats: Sequence[Sequence[Chain]]) -> list[Figure]:
    """The figures of some repeats, each with a chain of every kind, of one size."""
    by_kind = [{chain.kind: chain for chain in each} for each in repeats]
    aim = Aim(of=NAMES["asyncio"], at_most=RATIO_AIM)
    return [
        _figure(
            "a hop, median", by_kind, lambda chain: percentile(chain.took_us, 50) / (chain.robots - 1), aim
        ),
        _figure("the whole chain, p99", by_kind, lambda chain: percentile(chain.took_us, 99)),
        _figure("CPU time of a robot", by_kind, lambda chain: chain.cpu_us),
    ]


def _figure(
    name: str, repeats: Sequence[dict[str, Chain]], of: Callable[[Chain], float], aim: Aim | None = None
) -> Figure:
    stack, *bare = ([of(each[kind]) for each in repeats] for kind in (STACK, *BARE))
    baselines = {NAMES[kind]: values for kind, values in zip(BARE, bare, strict=True)}
    robots = repeats[0][STACK].robots
    return figure(f"{robots} robots: {name}", "us", stack, baselines=baselines, aim=aim)
