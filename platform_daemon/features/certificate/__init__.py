"""Certificates: what a recording says of a specimen, with uncertainties, to be signed."""

from platform_daemon.core.registry import Command, Feature

FEATURE = Feature(
    commands=(
        Command(
            name="certificate",
            attribute="certificate",
            help="Make a calibration certificate of a specimen: HTML, PDF/A, DCC (XML) and JSON.",
        ),
    ),
)
