"""Reproduce: both resonators are measured as in the paper, and its numbers are compared with the measured ones."""

from platform_daemon.core.registry import Command, Feature

FEATURE = Feature(
    commands=(
        Command(
            name="reproduce",
            attribute="reproduce",
            help="Measure both resonators as in the paper, and compare each of its numbers with the measured one.",
        ),
    ),
)
