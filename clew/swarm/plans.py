"""The fault plan that a user names; `drawn` stands for the one that the run's seed draws."""

from protocol.errors import UsageError
from protocol.faults.plan import NO_FAULTS, Plan, load

DRAWN = "drawn"
ROBOTS_MIN = 2  # most classes of faults are about a robot and another one


def plan_for(name: str | None, *, robots: int, seed: int) -> Plan:
    """The plan with this name or file, or the one that the seed draws; without a name, one without faults.

    Raises:
        UsageError: it cannot be loaded, or there are too few robots to draw faults for.
    """
    if name is None:
        return NO_FAULTS
    if name != DRAWN:
        return load(name, (DRAWN,))
    if robots < ROBOTS_MIN:
        raise UsageError(f"faults {DRAWN}: need at least {ROBOTS_MIN} robots, got {robots}")
    from clew.swarm.swarm import draw_faults  # noqa: PLC0415 - late: most runs draw nothing

    return draw_faults(seed, robots)
