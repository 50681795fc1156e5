"""Checks of the computer for unattended work: disk, memory, priority, clock, ports, and a service manager."""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
import socket
import stat
import subprocess
import threading
import time
from pathlib import Path
from tempfile import NamedTemporaryFile

import psutil

from drivers.clock import SystemClock
from drivers.realtime import set_realtime_priority
from platform_daemon.core.schemas.unattended import Finding, Verdict

GB = 1e9
_ROOM_WARN_B, _ROOM_FAIL_B = 10 * GB, 1 * GB
_MEMORY_WARN_B, _MEMORY_FAIL_B = 2 * GB, 0.5 * GB
_SLOW_SYNC_S = 0.5  # a shot is not acknowledged before that is over
_JUMP_S, _WATCHED_S = 0.02, 0.5
_UNSYNCHRONISED = 5  # TIME_ERROR of adjtimex(2)


def finding(check: str, found: str, fail: str = "", warn: str = "") -> Finding:
    """A finding.  fail, warn: the remedy, if the check fails or warns; failing counts before warning."""
    verdict = Verdict.FAIL if fail else Verdict.WARN if warn else Verdict.OK
    return Finding(check=check, verdict=verdict, found=found, remedy=fail or warn)


def disk(folder: Path) -> list[Finding]:
    """Free space, permission and fsync of a folder; of one that does not exist, of that in which it will be made."""
    try:
        there = _nearest(folder.absolute())
    except OSError as error:
        why = error.strerror or str(error)
        remedy = "give another --data folder, or make this one so that this account may use it"
        return [finding("disk: folder", f"{folder}: {why}", remedy)]
    room = psutil.disk_usage(str(there)).free
    few = "free the disk, or give another --data folder"
    text = f"{room / GB:.1f} GB free for {folder}"
    findings = [finding("disk: room", text, few if room < _ROOM_FAIL_B else "", few if room < _ROOM_WARN_B else "")]
    left = os.statvfs(there)
    if left.f_files:
        out = "delete files that are not needed" if left.f_favail < 10_000 else ""
        findings.append(finding("disk: files", f"{left.f_favail} more files can be made", out))
    try:
        took_s = _synced(there)
    except OSError as error:
        why = error.strerror or str(error)
        remedy = "mount it for writing, give it to this account, or repair it"
        return [*findings, finding("disk: write and fsync", f"{there}: {why}", remedy)]
    slow = "use a faster disk: every shot waits for it" if took_s > _SLOW_SYNC_S else ""
    return [*findings, finding("disk: write and fsync", f"1 MB is on the disk of {there} in {took_s:.3f} s", "", slow)]


def _nearest(folder: Path) -> Path:
    """The folder, or its nearest parent that exists.  Raises OSError if the folder cannot be made."""
    for each in (folder, *folder.parents):
        try:
            os.lstat(each)
        except FileNotFoundError:
            continue
        if not stat.S_ISDIR(os.stat(each).st_mode):  # of what a link leads to, which may be nothing
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
        return each
    return folder


def _synced(folder: Path) -> float:
    began = time.monotonic()
    with NamedTemporaryFile(dir=folder, prefix=".doctor-") as file:
        file.write(bytes(1_000_000))
        file.flush()
        os.fsync(file.fileno())
    return time.monotonic() - began


def memory() -> Finding:
    """Memory that is available now."""
    free = psutil.virtual_memory().available
    remedy = "end other programs, or add memory: the kernel kills the process that holds most"
    fail, warn = (remedy if free < least else "" for least in (_MEMORY_FAIL_B, _MEMORY_WARN_B))
    return finding("memory", f"{free / GB:.1f} GB available", fail, warn)


def priority() -> Finding:
    """May the thread that moves the shot have real-time priority?"""
    refusal: list[str | None] = []
    # In another thread: the priority of this one stays as it is.
    attempt = threading.Thread(target=lambda: refusal.append(set_realtime_priority(SystemClock())))
    attempt.start()
    attempt.join()
    remedy = "LimitRTPRIO=1 in the unit, or `rtprio 1` for its user in /etc/security/limits.d"
    if refusal[0] is None:
        return finding("priority", "shots go before what other programs do")
    return finding("priority", f"a busy computer can make shots late: {refusal[0]}", "", remedy)


def clock() -> list[Finding]:
    """Is the clock synchronised, does it jump, and has its zone daylight saving time?"""
    libc = ctypes.CDLL(None, use_errno=True)
    state = libc.adjtimex(ctypes.create_string_buffer(512))  # all zero: nothing is set
    remedy = "switch time synchronisation on: `timedatectl set-ntp true`"
    said = "the kernel says it is not synchronised" if state == _UNSYNCHRONISED else "synchronised"
    wrong = remedy if state == _UNSYNCHRONISED else ""
    if state < 0:
        said, wrong = f"not known: {os.strerror(ctypes.get_errno())}", "look at `timedatectl` by hand"
    apart = time.time() - time.monotonic()
    time.sleep(_WATCHED_S)
    jump_s = time.time() - time.monotonic() - apart
    hold = "find who sets the clock: times of shots jump with it" if abs(jump_s) > _JUMP_S else ""
    shifts = bool(time.daylight) and time.timezone != time.altzone
    zone = "schedules by the clock lose or gain an hour twice a year; UTC does not" if shifts else ""
    return [
        finding("clock: synchronised", said, "", wrong),
        finding("clock: jumps", f"{1e3 * jump_s:+.1f} ms in {_WATCHED_S:g} s", "", hold),
        finding("clock: zone", " / ".join(dict.fromkeys(time.tzname)), "", zone),
    ]


def port(number: int, name: str, *, ours: bool) -> Finding:
    """Is a TCP port of this computer free?  ours: a running daemon may hold it."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", number))
        except OSError as error:
            why = error.strerror or str(error)
            if ours:
                return finding(f"port: {name}", f"{number} is taken, a daemon runs")
            return finding(
                f"port: {name}", f"{number}: {why}", f"end the process that has it, or choose another --{name}"
            )
    return finding(f"port: {name}", f"{number} is free")


def service(unit: str) -> Finding:
    """Does a systemd unit with a watchdog restart the daemon?"""
    make = "install docs/platform-daemon.service, see docs/howto/unattended.md"
    systemctl = shutil.which("systemctl")
    if systemctl is None:
        return finding("service", "no systemd on this computer", "", "nothing restarts the daemon after its death")
    names = ("LoadState", "ActiveState", "WatchdogUSec", "ExecStopPost")
    command = [systemctl, "show", unit, *(f"--property={each}" for each in names)]
    try:
        said = subprocess.run(command, capture_output=True, text=True, timeout=10, check=False).stdout
    except (OSError, subprocess.TimeoutExpired) as error:
        return finding("service", f"systemd does not answer: {error}", "", make)
    properties = dict(line.partition("=")[::2] for line in said.splitlines())
    if properties.get("LoadState") != "loaded":
        return finding("service", f"there is no unit {unit}", "", make)
    missing = [name for name in names[2:] if properties.get(name, "0") in ("", "0", "infinity")]
    text = f"{unit} is {properties.get('ActiveState', 'unknown')}"
    return finding("service", text, "", f"{make}: it has no {', '.join(missing)}" if missing else "")
