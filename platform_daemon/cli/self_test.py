"""`platform-daemon self-test`: is the chain as the platform file says?"""

from __future__ import annotations

from drivers.validation import validated
from platform_daemon.reports import print_self_test

from .interrupts import heed_one_interrupt
from .options import EndpointsOption, ForceOption, JsonOption, PlatformOption, SetOption
from .output import must_not_exist, write_json
from .progress import progress


def self_test(
    platform: PlatformOption = "simulated",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    json_file: JsonOption = None,
    force: ForceOption = False,
) -> None:
    """Play a low tone on each coil, and hear it through the open receive contacts: cables, polarity, gain, switch."""
    from platform_daemon.app import start_engine
    from platform_daemon.engine import queue_self_test
    from platform_daemon.schemas import SelfTestReport, SelfTestRequest
    from platform_daemon.settings import load_platform

    must_not_exist(json_file, force, ".json")
    heed_one_interrupt()
    engine = start_engine(load_platform(platform, overrides or (), endpoints))
    try:
        job = queue_self_test(engine, validated(SelfTestRequest, {}, "self-test"))
        with progress() as display:
            display.watch(job)
    finally:
        engine.close()
    if job.error is not None:
        raise job.error
    assert isinstance(job.result, SelfTestReport)
    write_json(json_file, job.result)
    print_self_test(job.result)
