"""Would this computer, with this platform, run unattended?"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path

from drivers.errors import ConfigError, PlatformError
from drivers.inventory import find_devices
from drivers.registry import PlatformSection, outputs_outlive_process
from platform_daemon.core.schemas.platform import DeviceReport
from platform_daemon.core.schemas.unattended import Checkup, Finding
from platform_daemon.core.settings import PlatformFile

from . import host_checks
from .fault_latch import REMEDY, latched_fault
from .host_checks import finding
from .ownership import Owner, hold_devices, owner_of_devices, take_ownership
from .state_dir import state_dir_of

ReadBack = Callable[[Path], Sequence[DeviceReport]]
"""Each device as the daemon with this data folder read it back last.  Raises PlatformError."""


def run_preflight(file: PlatformFile, data: Path, ports: tuple[int, int], unit: str, read_back: ReadBack) -> Checkup:
    """All checks.  Devices are opened and read back unless a process owns them; outputs stay off.

    ports: of the daemon, main and stop; unit: of systemd; read_back: asks the daemon that owns the devices.
    """
    section = file.section
    findings, owner = _owner(section)
    findings += [
        *_lease(file),
        *_ports_of_devices(section),
        *_devices(section, owner, read_back),
        *host_checks.disk(data),
        host_checks.memory(),
        host_checks.priority(),
        *host_checks.clock(),
        *(
            host_checks.port(n, name, ours=owner is not None)
            for n, name in zip(ports, ("port", "stop-port"), strict=True)
        ),
        host_checks.service(unit),
    ]
    return Checkup(platform=section.name, findings=tuple(findings))


def _owner(section: PlatformSection) -> tuple[list[Finding], Owner | None]:
    """Who owns the devices, and whether a fault is latched."""
    try:
        if not outputs_outlive_process(section):
            return [finding("supervisor", "simulated devices die with their process and need no guard")], None
        owner = owner_of_devices(section)
        state_dir = state_dir_of(section)
        if owner is None:
            take_ownership(state_dir, section.name).release()
    except (PlatformError, OSError) as error:
        remedy = error.remedy if isinstance(error, ConfigError) else "repair the folder of the state"
        return [finding("supervisor", str(error), remedy or "see there")], None
    fault = latched_fault(state_dir)
    findings = [finding("supervisor", "no process owns the devices" if owner is None else f"owned by {owner}")]
    if owner is not None and not owner.lives:
        wait = "wait until its guard has switched off; then a person must look"
        findings = [finding("supervisor", f"{owner} has died, its guard still works", wait)]
    findings.append(finding("fault", "none stands" if fault is None else str(fault), "" if fault is None else REMEDY))
    return findings, owner


def _lease(file: PlatformFile) -> list[Finding]:
    lease_s, most_s = file.section.guard.lease_s, file.limits.max_lease_s
    text = f"{lease_s:g} s, " + ("not limited" if most_s is None else f"limit {most_s:g} s")
    beyond = "shorten guard.lease_s" if most_s is not None and lease_s > most_s else ""
    return [finding("lease", text, beyond, "set limits.max_lease_s" if most_s is None else "")]


def _ports_of_devices(section: PlatformSection) -> list[Finding]:
    """Permissions of serial ports, which can be read while another process has them open."""
    found = []
    for name in ("tx_rx_switch", "lna", "power_amplifier"):
        at = getattr(section, name).options().get("port")
        if isinstance(at, str) and at.startswith("/"):
            found.append(_permission(name, at))
    return found


def _permission(name: str, at: str) -> Finding:
    check = f"permission: {name}"
    if not os.path.exists(at):
        return finding(
            check, f"{at} is not there", "plug it in, or correct its port; docs/reference/wiring.md has the udev rule"
        )
    if not os.access(at, os.R_OK | os.W_OK):
        return finding(
            check, f"{at} is not ours", "put this account into the group that owns it; see docs/reference/wiring.md"
        )
    return finding(check, f"{at} may be read and written")


def _devices(section: PlatformSection, owner: Owner | None, read_back: ReadBack) -> list[Finding]:
    """Does each device answer?  A daemon that owns them says how it read them back last."""
    see = "see `platform-daemon devices`"
    try:
        if owner is not None and owner.lives and owner.data is not None:
            return [
                finding(f"device: {row.device}", row.error or "answers the daemon", see if row.error else "")
                for row in read_back(Path(owner.data))
            ]
        if owner is not None:
            return [finding("devices", f"in use by {owner}")]
        with hold_devices(section) if outputs_outlive_process(section) else nullcontext():
            return [
                finding(f"device: {each.device}", "answers")
                if each.error is None
                else finding(f"device: {each.device}", each.error.what, each.error.remedy or see)
                for each in find_devices(section)
            ]
    except PlatformError as error:
        return [finding("devices", str(error), "", error.remedy or see)]
