"""Measurands: what a resonator is a sensor for, and what it reads, with uncertainty."""

from platform_daemon.core.registry import Feature

FEATURE = Feature(
    routes=(".routes",),
    tag=("measurands", "What resonators are sensors for"),
    errors=(".library",),
)
