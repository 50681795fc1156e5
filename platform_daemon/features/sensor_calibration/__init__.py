"""Calibrating a resonator as a sensor: by recordings or by those of a schedule, against a reference."""

from platform_daemon.core.registry import Command, Feature

FEATURE = Feature(
    routes=(".routes",),
    commands=(
        Command(
            name="measurand",
            attribute="measurand_app",
            help="Use a resonator as a sensor: calibrate against a reference, read with uncertainty, list.",
        ),
    ),
)
