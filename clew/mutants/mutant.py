"""A mutant: our source with one rule broken."""

from dataclasses import dataclass

SEEDS_MAX = 300


@dataclass(frozen=True, slots=True)
class Edit:
    """A piece of source and its replacement."""

    file: str
    before: str
    after: str


@dataclass(frozen=True, slots=True)
class Mutant:
    """Our source with one rule broken."""

    name: str
    rule: str
    """The rule that it breaks."""
    edits: tuple[Edit, ...]
    seeds_max: int = SEEDS_MAX
    seed: int = 1
    """The seed that caught it when it was last searched for; a search begins with it."""
    breaks: tuple[str, ...] = ()
    """The invariants of which a catch breaks one, or the kind of surprise; else it is an accident."""
    check: str = ""
    """The test that catches it, where no seed of a swarm has: what it needs, no swarm draws."""


def mutant(
    name: str,
    rule: str,
    file: str,
    before: str,
    after: str,
    *,
    seed: int = 1,
    breaks: tuple[str, ...] = (),
    check: str = "",
) -> Mutant:
    """A mutant with one edit."""
    return Mutant(name, rule, (Edit(file, before, after),), seed=seed, breaks=breaks, check=check)
