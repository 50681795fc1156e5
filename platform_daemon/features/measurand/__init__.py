"""Measurands: what a resonator is a sensor for, calibrated against a reference and read with uncertainty."""

from platform_daemon.core.registry import Command, Feature

FEATURE = Feature(
    routes=(".routes",),
    tag=("measurands", "What resonators are sensors for"),
    errors=(".library",),
    commands=(
        Command(
            name="measurand",
            attribute="measurand_app",
            help="Use a resonator as a sensor: calibrate against a reference, read with uncertainty, list.",
        ),
    ),
)
