"""`platform-daemon outputs-off | reset-fault`: what a person, or systemd, does when nobody owns the devices."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import DeviceDenied

from .auditing import audit_done
from .options import EndpointsOption, PlatformOption, SetOption

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

    For systemd's ExecStopPost=, and by hand.  A daemon that runs is told to stop everything instead.
    """
    section = _section(platform, overrides, endpoints)
    from platform_daemon import supervisor

    if not supervisor.needs_guard(section):
        print("outputs are off: simulated devices live in the process that uses them")
        return
    running = _daemon(section)
    if running is None:
        supervisor.outputs_off(section)
    else:
        from platform_daemon.link import RemoteHardware

        RemoteHardware(running).outputs_off()
        audit_done(running, "stop", "outputs-off")
    print("outputs are off" if running is None else f"outputs are off; the daemon on {running} has stopped everything")


def reset_fault(
    by: ByOption,
    reason: ReasonOption = "",
    platform: PlatformOption = "lab",
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
) -> None:
    """Let power out again after an owner of the devices has died: outputs are proved off first.

    A daemon that runs is asked to do it.  Look at the platform first.
    """
    section = _section(platform, overrides, endpoints)
    from platform_daemon import supervisor

    if not supervisor.needs_guard(section):
        print("no fault stands: simulated devices live in the process that uses them")
        return
    running = _daemon(section)
    if running is None:
        found = supervisor.reset_fault(section, by, reason)
        fault = None if found is None else str(found)
    else:
        from platform_daemon.link import RemoteHardware
        from platform_daemon.schemas import FaultUnlock

        fault = RemoteHardware(running).unlock(FaultUnlock(by=by, reason=reason)).fault
        audit_done(running, "reset_fault", f"{by}: {reason}")
    print("no fault stood" if fault is None else f"cleared by {by}: {fault}")


def _section(platform: str, overrides: list[str] | None, endpoints: Path | None) -> PlatformSection:
    from platform_daemon.settings import load_platform

    return load_platform(platform, overrides or (), endpoints).section


def _daemon(section: PlatformSection) -> Path | None:
    """Data folder of the daemon that owns the devices; None: nobody does.

    Raises DeviceDenied for a command that does, such as `measure`.
    """
    from platform_daemon.supervisor import owner_of, place_of

    owner = owner_of(place_of(section))
    if owner is None or not owner.lives:
        return None
    if owner.data is None:
        remedy = f"end it: Ctrl-C in its terminal, or `kill {owner.pid}`, switches its outputs off"
        raise DeviceDenied("another program owns the devices", where="platform", why=f"it is {owner}", remedy=remedy)
    return Path(owner.data)
