"""Reproduce: both resonators are measured as in the paper, and its numbers are compared with the measured ones."""

from platform_daemon.core.registry import Command, Feature, JobKind

FEATURE = Feature(
    job=JobKind(
        name="reproduction",
        plural="reproductions",
        request=".schema:ReproductionRequest",
        result=".schema:Claims",
        plan=".work:plan",
        shows_pause=True,
        submits_steps=True,
        resumable=True,
        worker_memory_mb=8_000,
        worker_time_s=4 * 3600.0,
        plans_on_a_core=True,
        article="A reproduction",
        description="A campaign as the paper's; `result` is what `claims.json` holds, and empty before its end.",
        title="Measure as the paper did",
        about="""
            Queue the paper's campaign: a thread and a jewel, each tuned, ramped and measured, and the paper's numbers
            beside the measured ones.

            It is made of procedures, which wait their turn among all others.  Both resonators need a platform that
            changes them itself; of another one ask for one of them.
        """,
        got="State, progress with time left, and the claims once they are there.",
        cancelled="Cancel.  A running shot ends within 0.1 s with outputs off and is discarded; shots on disk stay.",
        examples=("reproduction_job",),
    ),
    routes=(".routes",),
    tag=("reproductions", "The paper's numbers beside the measured ones"),
    commands=(
        Command(
            name="reproduce",
            attribute="reproduce",
            help="Measure both resonators as in the paper, and compare each of its numbers with the measured one.",
        ),
    ),
)
