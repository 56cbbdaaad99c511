"""Clew: drive, break and understand fleets of robots. `docs/python.md`.

    run = clew.rehearse("grove", robots=5, seed=7, faults=[clew.drop("ahead", p=0.3)])
    with clew.launch("grove", speed="max") as fleet:            # real processes
        fleet.until("step.planned", step=2)
        run = fleet.finish()
    run = clew.open("runs/latest")

A name is loaded when it is first used, so `import clew` takes a few milliseconds.

>>> sorted(clew.__all__)[:6]
['Entry', 'Fleet', 'Law', 'Run', 'Seen', 'Step']
"""

TYPE_CHECKING = False  # type checkers take it as true; the module `typing` takes longer than all else here
if TYPE_CHECKING:
    from agents.navigation.law import Law, Seen, register_law
    from agents.navigation.step import Step
    from clew.api.compare import compare
    from clew.api.entries import Entry
    from clew.api.faults import (
        corrupt,
        delay,
        drop,
        duplicate,
        freeze,
        kill,
        partition,
        reorder,
        restart,
        slow,
        thaw,
    )
    from clew.api.fleet import Fleet, WaitFailedError
    from clew.api.launched import launch
    from clew.api.rehearsed import rehearse
    from clew.api.run import Run
    from clew.api.run import open_run as open  # noqa: A004 - `clew.open(run)`, as `tarfile.open` and others
    from protocol.errors import UsageError

__all__ = [
    "Entry",
    "Fleet",
    "Law",
    "Run",
    "Seen",
    "Step",
    "UsageError",
    "WaitFailedError",
    "compare",
    "corrupt",
    "delay",
    "drop",
    "duplicate",
    "freeze",
    "kill",
    "launch",
    "open",
    "partition",
    "register_law",
    "rehearse",
    "reorder",
    "restart",
    "slow",
    "thaw",
]

_PLACES = {
    **{name: ("clew.api.faults", name) for name in __all__},
    "Entry": ("clew.api.entries", "Entry"),
    "Fleet": ("clew.api.fleet", "Fleet"),
    "Law": ("agents.navigation.law", "Law"),
    "Run": ("clew.api.run", "Run"),
    "Seen": ("agents.navigation.law", "Seen"),
    "Step": ("agents.navigation.step", "Step"),
    "UsageError": ("protocol.errors", "UsageError"),
    "WaitFailedError": ("clew.api.fleet", "WaitFailedError"),
    "compare": ("clew.api.compare", "compare"),
    "launch": ("clew.api.launched", "launch"),
    "open": ("clew.api.run", "open_run"),
    "register_law": ("agents.navigation.law", "register_law"),
    "rehearse": ("clew.api.rehearsed", "rehearse"),
}
"""Where each name is: a fault, if nothing else is said of it."""


if not TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        if name not in _PLACES:
            raise AttributeError(f"module 'clew' has no attribute {name!r}")
        from importlib import import_module  # noqa: PLC0415 - not needed for `import clew`

        module, kept = _PLACES[name]
        found = globals()[name] = getattr(import_module(module), kept)
        return found


def __dir__() -> list[str]:
    return sorted(__all__)
