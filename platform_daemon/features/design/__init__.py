"""Design numbers of a resonator, and the forces of its manufacturing defects."""

from platform_daemon.core.registry import Command, Feature

FEATURE = Feature(
    routes=(".routes",),
    tag=("design", "What magnets and bearing alone say of a resonator, and manufacturing defects"),
    commands=(
        Command(
            name="design",
            attribute="design",
            help="Print what magnets and bearing alone say: moment, frequency, forces, friction, and the paper's six "
            "steps.",
        ),
        Command(
            name="defects",
            attribute="defects",
            help="Equivalent perpendicular force of a manufacturing defect: what pushes the rotor into side modes.",
        ),
    ),
)
