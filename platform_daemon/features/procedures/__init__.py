"""Procedures: jobs that submit one series after the other and decide the next from its fits."""

from platform_daemon.core.registry import Feature, JobKind

FEATURE = Feature(
    job=JobKind(
        name="procedure",
        plural="procedures",
        request=".schema:AnyProcedureRequest",
        result=".schema:ProcedureResult",
        grows=True,
        plan=".planned:plan",
        dry_run=".planned:dry_run",
        summary=".schema:ProcedureSummary",
        shows_pause=True,
        submits_steps=True,
        worker_memory_mb=8_000,
        worker_time_s=3600.0,
        article="A procedure",
        description="A procedure: steps one after the other, each an acquisition, all shots in one recording; `result` "
        "grows with every step.",
        title="Measure step by step",
        about="""
            Queue a procedure: a sweep over keys of an acquisition, or a characterisation of a resonator.

            Every step is checked first: one outside the safety envelope is answered 422 with its number, and nothing
            moves. Procedures run one after the other.  Each step is an acquisition that waits its turn among all
            others; the shots of all steps are in one recording, which has the id of the procedure.
        """,
        plans_on_a_core=True,
        examples=("procedure_job", "tune_job"),
        got="State, progress with time left, and every step so far: values, medians of the fits, verdict.",
        cancelled="Cancel.  A running shot ends within 0.1 s with outputs off and is discarded; shots on disk stay.",
    ),
    routes=(".routes",),
    tag=("procedures", "Several steps, each a series, in one recording: sweep, tune, ramp"),
)
