"""Would this computer, with this platform, run unattended?"""

from __future__ import annotations

import os
from pathlib import Path

from drivers.errors import ConfigError, PlatformError
from drivers.inventory import find_devices
from drivers.registry import PlatformSection
from platform_daemon.schemas import Checkup, Finding
from platform_daemon.settings import PlatformFile

from . import machine
from .lock_file import REMEDY, standing
from .machine import judged
from .owner import needs_guard
from .ownership import Owner, owner_of, take
from .places import place_of


def examine(file: PlatformFile, data: Path, ports: tuple[int, int], unit: str) -> Checkup:
    """Everything that is looked at.  Devices are opened and read back unless somebody owns them; outputs stay off.

    ports: of the daemon, main and stop; unit: of systemd.
    """
    section = file.section
    findings, owner = _owner(section)
    findings += [
        *_lease(file),
        *_ports_of_devices(section),
        *_devices(section, owner),
        *machine.disk(data),
        machine.memory(),
        machine.priority(),
        *machine.clock(),
        *(machine.port(n, name, ours=owner is not None) for n, name in zip(ports, ("port", "stop-port"), strict=True)),
        machine.service(unit),
    ]
    return Checkup(platform=section.name, findings=tuple(findings))


def _owner(section: PlatformSection) -> tuple[list[Finding], Owner | None]:
    """Who owns the devices, and whether a fault stands."""
    if not needs_guard(section):
        return [judged("supervisor", "simulated devices die with their process and need no guard")], None
    try:
        place = place_of(section)
        owner = owner_of(place)
        if owner is None:
            take(place, section.name).release()
    except (PlatformError, OSError) as error:
        remedy = error.remedy if isinstance(error, ConfigError) else "repair the folder of the state"
        return [judged("supervisor", str(error), remedy or "see there")], None
    fault = standing(place)
    findings = [judged("supervisor", "nobody owns the devices" if owner is None else f"owned by {owner}")]
    if owner is not None and not owner.lives:
        wait = "wait until its guard has switched off; then somebody must look"
        findings = [judged("supervisor", f"{owner} has died, its guard still works", wait)]
    findings.append(judged("fault", "none stands" if fault is None else str(fault), "" if fault is None else REMEDY))
    return findings, owner


def _lease(file: PlatformFile) -> list[Finding]:
    lease_s, most_s = file.section.guard.lease_s, file.limits.max_lease_s
    text = f"{lease_s:g} s, " + ("not limited" if most_s is None else f"limit {most_s:g} s")
    beyond = "shorten guard.lease_s" if most_s is not None and lease_s > most_s else ""
    return [judged("lease", text, beyond, "set limits.max_lease_s" if most_s is None else "")]


def _ports_of_devices(section: PlatformSection) -> list[Finding]:
    """Serial ports by their permission alone, which holds while somebody else has them open, too."""
    found = []
    for name in ("tx_rx_switch", "lna", "power_amplifier"):
        at = getattr(section, name).options().get("port")
        if isinstance(at, str) and at.startswith("/"):
            found.append(_permission(name, at))
    return found


def _permission(name: str, at: str) -> Finding:
    check = f"permission: {name}"
    if not os.path.exists(at):
        return judged(check, f"{at} is not there", "plug it in, or correct its port; docs/wiring.md has the udev rule")
    if not os.access(at, os.R_OK | os.W_OK):
        return judged(check, f"{at} is not ours", "put this account into the group that owns it; see docs/wiring.md")
    return judged(check, f"{at} may be read and written")


def _devices(section: PlatformSection, owner: Owner | None) -> list[Finding]:
    """Each device answers; not asked while somebody owns them."""
    if owner is not None:
        return [judged("devices", "in use: ask the daemon, GET /devices")]
    return [
        judged(f"device: {each.device}", "answers")
        if each.error is None
        else judged(f"device: {each.device}", each.error.what, each.error.remedy or "see `platform-daemon devices`")
        for each in find_devices(section)
    ]
