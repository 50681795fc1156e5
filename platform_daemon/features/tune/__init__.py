"""Tuning: the natural frequency of a resonator and the sequence that suits it."""

from platform_daemon.core.registry import Command, Feature, Procedure

FEATURE = Feature(
    procedure=Procedure(
        name="tune",
        request=".schema:TuneRequest",
        outcome=".schema:TuneOutcome",
        plan=".work:plan",
    ),
    commands=(
        Command(
            name="tune",
            attribute="tune",
            help="Find f_nat in at most five weak shots, and from it f_TX, t_TX, t_RX and the pause; kept as "
            "the preset.",
        ),
    ),
)
