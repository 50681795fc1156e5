"""Characterisation: the paper's tables and figures from many shots of one resonator."""

from platform_daemon.core.registry import Command, Feature, JobKind, Procedure

FEATURE = Feature(
    job=JobKind(
        name="characterisation",
        plural="characterisations",
        request=".schema:CharacterisationRequest",
        result=".schema:CharacterisationReport",
        plan=".tables_work:plan",
        needs_hardware=False,
        worker_memory_mb=8_000,
        worker_time_s=2 * 3600.0,
        article="A characterisation",
        description="A characterisation; `result` is what `characterise --json` writes, and empty before that.",
        title="Characterise a resonator",
        about="""
            Fit every shot of a recording over N50 and D30: the paper's tables, and whether the two windows agree.

            `result` is the same object that `platform-daemon characterise --json` writes.
        """,
        got="State, progress with time left, and the result once it is there.",
        cancelled="Cancel after the fit under way.",
        examples=("characterisation_job",),
    ),
    procedure=Procedure(
        name="characterise",
        request=".schema:CharacteriseRequest",
        outcome=".schema:CharacteriseOutcome",
        plan=".work:plan",
    ),
    routes=(".routes",),
    tag=("characterisations", "The tables of the paper, from many shots of one resonator"),
    commands=(
        Command(
            name="characterise",
            attribute="characterise",
            help="Fit many shots over N50 and D30: tables and figures of the paper, and whether the two windows agree.",
        ),
    ),
)
