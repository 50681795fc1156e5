"""Calibration of the receive side (P and frequency response) and of the transmit side."""

from platform_daemon.core.registry import Command, Feature, JobKind

FEATURE = Feature(
    job=JobKind(
        name="calibration",
        plural="calibrations",
        request="platform_daemon.core.schemas.requests:CalibrationRequest",
        result="platform_daemon.core.schemas.calibrations:CalibrationReport",
        plan=".work:plan",
        asks_operator=True,
        article="A calibration",
        description="A calibration; `result` is what `calibrate --json` writes, and empty before that.",
        title="Calibrate the receive or the transmit side",
        about="""
            Queue a calibration.

            It waits its turn among the acquisitions and writes a new version of its file.  The daemon keeps
            its calibration in use until it is instructed to adopt this one: POST /calibrations/adopt.
        """,
        examples=("calibration_job",),
        got="State, progress, the operator's part if there is one, and the result.",
        cancelled="Cancel.  A running shot ends within 0.1 s with outputs off; no file is written.",
    ),
    routes=(".routes",),
    tag=("calibrations", "Of the receive and of the transmit side"),
    commands=(
        Command(
            name="calibrate",
            attribute="calibrate_app",
            help="Calibrate the platform; every run writes a new version of its file.",
        ),
    ),
)
