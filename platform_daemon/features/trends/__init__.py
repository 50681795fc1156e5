"""Trends of a specimen over months, with control charts and named changes."""

from platform_daemon.core.registry import Command, Feature

FEATURE = Feature(
    routes=(".routes",),
    tag=("specimens", "What specimens do over months"),
    errors=(".indexed",),
    commands=(
        Command(
            name="trend",
            attribute="trend",
            help="Show how a specimen changes over months: values at one temperature, control charts, named changes.",
        ),
        Command(
            name="index",
            attribute="index_app",
            help="The index of recordings, from which trends are computed; it can be rebuilt.",
        ),
    ),
)
