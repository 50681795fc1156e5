"""Work by the calendar, and the ledger of what became of each start."""

from platform_daemon.core.registry import Command, Feature

FEATURE = Feature(
    routes=(".routes",),
    tag=("schedules", "Work by the calendar, and what became of each start"),
    errors=(".schedules",),
    service=".contract:ScheduleService",
    commands=(
        Command(
            name="schedule",
            attribute="schedule_app",
            help="Schedules of a running daemon: work by the calendar, and the ledger of its starts.",
        ),
    ),
)
