"""Uncertainty budgets: what a fitted value is worth, and what makes it uncertain."""

from platform_daemon.core.registry import Command, Feature

FEATURE = Feature(
    routes=(".routes",),
    commands=(
        Command(
            name="budget",
            attribute="budget",
            help="Uncertainty budget of a fit or of a series: what contributes, and what is not declared.",
        ),
    ),
)
