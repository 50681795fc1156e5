"""Reproduce: both resonators are measured as in the paper, and its numbers stand beside ours."""

from platform_daemon.core.registry import Command, Feature

FEATURE = Feature(
    commands=(
        Command(
            name="reproduce",
            attribute="reproduce",
            help="Measure both resonators as in the paper, and write each of its numbers beside ours with a verdict.",
        ),
    ),
)
