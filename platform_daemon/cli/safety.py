"""`platform-daemon outputs-off | reset-fault`: what a person, or systemd, does when no program owns the devices."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from platform_daemon.core.command_line.auditing import audit_done
from platform_daemon.core.command_line.options import EndpointsOption, PlatformOption, SetOption

from .owning_daemon import daemon_of

if TYPE_CHECKING:
    from drivers.registry import PlatformSection

ByOption = Annotated[str, typer.Option("--by", help="Name of the person who has looked at the platform.")]
ReasonOption = Annotated[str, typer.Option(help="What was found.")]


def outputs_off(
    platform: PlatformOption = "lab",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
) -> None:
    """Switch all outputs off and prove it, all devices at once; exit code 0 only if it is proved.

    For systemd's ExecStopPost=, and by hand.  A running daemon is instructed to stop everything instead.
    """
    from platform_daemon.core.guard.emergency_off import outputs_off

    section = _section(platform, overrides, endpoints)
    from drivers.registry import outputs_outlive_process

    if not outputs_outlive_process(section):
        print("outputs are off: simulated devices live in the process that uses them")
        return
    running = daemon_of(section)
    if running is None:
        outputs_off(section)
    else:
        from platform_daemon.core.service.proxy import PlatformServiceProxy

        PlatformServiceProxy(running).outputs_off()
        audit_done(running, "stop", "outputs-off")
    print("outputs are off" if running is None else f"outputs are off; the daemon on {running} has stopped everything")


def reset_fault(
    by: ByOption,
    reason: ReasonOption = "",
    platform: PlatformOption = "lab",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
) -> None:
    """Reset the fault latch, so that power may go out again; all outputs are proved off first.

    A running daemon is instructed to do it.  Look at the platform first.
    """
    from platform_daemon.core.guard.emergency_off import reset_fault

    section = _section(platform, overrides, endpoints)
    from drivers.registry import outputs_outlive_process

    if not outputs_outlive_process(section):
        print("no fault stands: simulated devices live in the process that uses them")
        return
    running = daemon_of(section)
    if running is None:
        found = reset_fault(section, by, reason)
        fault = None if found is None else str(found)
    else:
        from platform_daemon.core.schemas.unattended import FaultUnlock
        from platform_daemon.core.service.proxy import PlatformServiceProxy

        fault = PlatformServiceProxy(running).unlock(FaultUnlock(by=by, reason=reason)).fault
        audit_done(running, "reset_fault", f"{by}: {reason}")
    print("no fault stood" if fault is None else f"cleared by {by}: {fault}")


def _section(platform: str, overrides: list[str] | None, endpoints: Path | None) -> PlatformSection:
    from platform_daemon.core.settings import load_platform

    return load_platform(platform, overrides or (), endpoints).section
