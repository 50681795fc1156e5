"""Sweeps: a series for each value of one or several keys."""

from platform_daemon.core.registry import Command, Feature, Procedure

FEATURE = Feature(
    procedure=Procedure(
        name="sweep",
        request=".schema:SweepRequest",
        plan=".work:plan",
    ),
    commands=(
        Command(
            name="sweep",
            attribute="sweep",
            help="Sweep keys of a series: every step is fitted and logged, all shots are in one recording.",
        ),
    ),
)
