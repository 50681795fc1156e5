"""The ramp to the side-mode threshold."""

from platform_daemon.core.registry import Command, Feature, Procedure

FEATURE = Feature(
    procedure=Procedure(
        name="ramp",
        request=".schema:RampRequest",
        outcome=".schema:RampOutcome",
        plan=".work:plan",
    ),
    commands=(
        Command(
            name="ramp",
            attribute="ramp",
            help="Raise the field until side modes show; find their threshold and the field to work at.",
        ),
    ),
)
