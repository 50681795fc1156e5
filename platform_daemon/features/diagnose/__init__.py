"""Diagnosis of recordings: what the declared model lacks; adoption of a better model."""

from platform_daemon.core.registry import Command, Feature, JobKind

FEATURE = Feature(
    job=JobKind(
        name="diagnosis",
        plural="diagnoses",
        request=".request_schema:DiagnosisRequest",
        result="platform_daemon.diagnosis.report_schema:DiagnosisReport",
        plan=".work:plan",
        scheduled="platform_daemon.features.schedules.schema:DiagnosisWorkRequest",
        needs_hardware=False,
        worker_memory_mb=12_000,
        worker_time_s=2 * 3600.0,
        article="A diagnosis",
        description="A diagnosis; `result` is what `diagnose --json` writes, and empty before that.",
        title="Diagnose recordings",
        about="""
            Say what the declared model lacks.  `result` is the same object that `platform-daemon diagnose --json`
            writes.
        """,
        got="State, progress, and the result once it is there.",
        cancelled="Cancel after the step under way.",
        examples=("diagnosis_job",),
    ),
    routes=(".routes",),
    tag=("diagnoses", "What the declared model lacks"),
    commands=(
        Command(
            name="adopt",
            module=".adopt_command",
            attribute="adopt",
            help="Adopt the effects of a diagnosis: a named, versioned model for fits, with the evidence for it.",
        ),
        Command(
            name="diagnose",
            attribute="diagnose",
            help="Find effects that the declared model lacks: strength, significance, and better prediction.",
        ),
    ),
)
