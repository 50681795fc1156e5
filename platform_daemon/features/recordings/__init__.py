"""Recordings on disk: list, describe, download, plot."""

from platform_daemon.core.registry import Command, Feature

FEATURE = Feature(
    routes=(".routes",),
    tag=("recordings", "What was measured, with its dm/dt"),
    commands=(
        Command(name="info", attribute="info", help="Show what a recording, an angle series or a table contains."),
        Command(
            name="plot",
            attribute="plot",
            help="Draw dm/dt, volts or an angle with the fit over it, the residual and the spectrum.",
        ),
    ),
)
