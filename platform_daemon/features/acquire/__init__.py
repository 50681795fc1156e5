"""A series of shots: plan, acquisition, on-line fits."""

from platform_daemon.core.registry import Command, Feature, JobKind

FEATURE = Feature(
    job=JobKind(
        name="acquisition",
        plural="acquisitions",
        request="platform_daemon.core.schemas.requests:AcquisitionRequest",
        result="platform_daemon.core.schemas.acquisitions:AcquisitionResult",
        grows=True,
        plan=".series_plan:plan",
        dry_run=".series_plan:dry_run",
        summary="platform_daemon.core.schemas.acquisitions:AcquisitionSummary",
        resumable=True,
        article="A series of shots",
        description="A series of shots; `result` grows with every shot on disk, its id is that of the recording.",
        title="Measure a series",
        about="""
            Queue an acquisition.

            Acquisitions run one after the other in the order of the queue; `state` is `queued` until then.  The request
            is checked against the safety limits first: a rejected one is answered 422 and nothing moves.
        """,
        examples=("acquisition_job",),
        got="State, progress with time left, and the on-line fits so far.",
        cancelled="Cancel.  A running shot ends within 0.1 s with outputs off and is discarded; shots on disk stay.",
    ),
    routes=(".routes",),
    tag=("acquisitions", "Series of shots"),
    commands=(
        Command(
            name="measure",
            attribute="measure",
            help="Measure a series of shots and fit each; every shot is on disk before it counts.",
        ),
    ),
)
