"""The self-test: is the measuring chain as the platform file declares it?"""

from platform_daemon.core.registry import Command, Feature, JobKind

FEATURE = Feature(
    job=JobKind(
        name="self_test",
        plural="self-tests",
        request=".schema:SelfTestRequest",
        result=".schema:SelfTestReport",
        plan=".work:plan",
        article="A self-test",
        description="A self-test; `result` is what `self-test --json` writes, and empty before that, or if it has "
        "failed.",
        title="Is the chain as it should be?",
        about="""
            Queue a self-test: a weak tone on each coil, measured by its leakage through the open receive contacts.

            It waits its turn, and is made even where the platform file switches it off before series.  A chain that
            is not as the platform file says is a job that has failed with `self-test-failed`, which names what is
            wrong.
        """,
        examples=("self_test_job",),
        got="State and progress, and gain and isolation by coil once it has passed.",
    ),
    tag=("self-tests", "Is the chain as the platform file says?"),
    commands=(
        Command(
            name="self-test",
            attribute="self_test",
            help="Play a weak tone on each coil and measure its leakage: tests cables, polarity, gain and switch.",
        ),
    ),
)
