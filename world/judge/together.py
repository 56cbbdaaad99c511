"""The verdict on several fleets that shared one ground: that of each fleet, and whether any two touched."""

from collections.abc import Mapping

from msgspec import Struct

from protocol.exit_codes import ExitCode
from world.judge.between import Between, Encounter
from world.judge.verdict import Verdict

CONTACTS_TOLD_MAX = 20


class FleetOutcome(Struct, frozen=True, kw_only=True):
    """What the verdict on all says of one fleet; its own verdict says the rest."""

    ok: bool
    exit_code: int
    reason: str
    robots: int
    robots_arrived: int
    sim_s: float


class TogetherVerdict(Struct, frozen=True, kw_only=True):
    """`verdict.json` of a run with several fleets; docs/fleets.md explains the fields."""

    ok: bool
    exit_code: int
    reason: str
    scenario: str
    seed: int
    fleets: dict[str, FleetOutcome]
    between_m_min: float
    """The least distance between hulls of different fleets; it must be above 0."""
    nearest: Encounter
    contacts: tuple[Encounter, ...]
    """The first contact of each pair of robots that touched, as far as they are told."""
    contact_count: int
    sim_s: float
    wall_s: float
    """Of all fleets together: they run in one process."""
    cpu_s: float
    """Likewise."""


def pass_together(
    scenario: str,
    seed: int,
    verdicts: Mapping[str, Verdict],
    between: Between,
) -> TogetherVerdict:
    """The verdict on all fleets from those on each, and from what was between them."""
    nearest, contacts = between.least, between.contacts
    assert nearest is not None, "the starts are judged before all"
    failed = [(name, each) for name, each in verdicts.items() if not each.ok]
    exit_code, reason = int(ExitCode.OK), "every fleet has arrived"
    if contacts:
        exit_code, reason = ExitCode.FAILED, f"two fleets touched: {contacts[0]}"
    elif failed:
        name, first = failed[0]
        exit_code, reason = first.exit_code, f"{name}: {first.reason}"
    return TogetherVerdict(
        ok=exit_code == ExitCode.OK,
        exit_code=exit_code,
        reason=reason,
        scenario=scenario,
        seed=seed,
        fleets={
            name: FleetOutcome(
                ok=each.ok,
                exit_code=each.exit_code,
                reason=each.reason,
                robots=each.robots,
                robots_arrived=each.robots_arrived,
                sim_s=each.sim_s,
            )
            for name, each in verdicts.items()
        },
        between_m_min=nearest.distance_m,
        nearest=nearest,
        contacts=tuple(contacts[:CONTACTS_TOLD_MAX]),
        contact_count=len(contacts),
        sim_s=max(each.sim_s for each in verdicts.values()),
        wall_s=max(each.wall_s for each in verdicts.values()),
        cpu_s=max(each.cpu_s for each in verdicts.values()),
    )
