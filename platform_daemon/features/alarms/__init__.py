"""Alarms: rules over events and over the computer, and the board of open alarms."""

from platform_daemon.core.registry import Feature

FEATURE = Feature(
    routes=(".routes",),
    tag=("alarms", "Alarms, and numbers for Prometheus"),
    errors=(".board",),
)
