"""Fits of recordings: opening, calibrated signal, noise, batches, sliding windows, harmonics, derived quantities."""

from platform_daemon.core.registry import Command, Feature, JobKind

FEATURE = Feature(
    job=JobKind(
        name="fit",
        plural="fits",
        request=".request_schema:RecordingFitRequest",
        result="platform_daemon.core.schemas.fits:FitReport",
        plan=".work:plan",
        scheduled="platform_daemon.features.schedules.schema:FitWorkRequest",
        needs_hardware=False,
        worker_memory_mb=8_000,
        worker_time_s=3600.0,
        article="A fit",
        description="A fit of a stored recording; `result` is what `fit --json` writes, and empty before that.",
        title="Fit a recording",
        about="""
            Fit an angle file, or every excited frame of a recording, or of those in `frames`.

            `result` is the same object that `platform-daemon fit --json` writes.
        """,
        got="State, progress, and the result once it is there.",
        cancelled="Cancel after the frame under way.",
        examples=("fit_job",),
    ),
    routes=(".routes", ".stored_frame_routes"),
    tag=("fits", "Of stored recordings"),
    commands=(
        Command(name="fit", attribute="fit", help="Fit the frames of one or more recordings."),
        Command(
            name="harmonics",
            module=".harmonics_command",
            attribute="harmonics",
            help="Estimate f_nat, m_r, amplitude and decay from the harmonics of 24 periods: a cross-check of the fit.",
        ),
        Command(
            name="predict",
            module=".predict_command",
            attribute="predict",
            help="Predict the smallest standard deviations a measurement can reach (Cramer-Rao bound, white noise).",
        ),
        Command(
            name="slide",
            module=".sliding_command",
            attribute="slide",
            help="Fit window by window: with a complete model f_nat, m_r, lambda and T_f/I are flat lines.",
        ),
    ),
)
