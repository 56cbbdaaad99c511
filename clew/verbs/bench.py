"""`clew bench`: measures how long things take."""

import click

from clew.verbs.group import Late, LateGroup


@click.group(
    cls=LateGroup,
    late={
        "busy": Late("bench_busy:busy", "Run live fleets beside busy processes."),
        "forming": Late("bench_forming:forming_", "Rehearse queues until they have formed a strand."),
        "healing": Late("bench_healing:healing", "How soon live fleets replace a lost leader."),
        "hop": Late("bench_hop:hop", "How fast news travels down a strand of processes."),
        "scale": Late("bench_scale:scale", "What fleets of many real processes cost."),
        "soak": Late("bench_soak:soak", "Whether anything grows while robots die and come back."),
        "loss": Late("bench_loss:loss", "How long a fleet takes when messages are lost."),
        "page": Late("bench_page:page", "Write docs/performance.md from results."),
        "plan": Late("bench_plan:plan", "Time the plans of leaders, as a whole and by part."),
        "rehearsal": Late("bench_rehearsal:rehearsal", "Time whole rehearsals."),
    },
)
def bench() -> None:
    """Measure how long things take on this machine."""
