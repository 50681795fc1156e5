"""The file system as a service sees it that runs by the unit of the documents: its own /tmp, no homes, nothing writable
but what the unit names.  Made of mount namespaces, so that it works where no systemd runs."""

from __future__ import annotations

import configparser
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
UNIT = ROOT / "docs/platform-daemon.service"


def unit_section() -> dict[str, str]:
    """The section [Service]; of a key that is there several times the last value."""
    parser = configparser.RawConfigParser(strict=False)
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read(UNIT)
    return dict(parser["Service"])


def _can_isolate() -> bool:
    made = subprocess.run(["unshare", "--mount", "true"], capture_output=True, check=False)
    return made.returncode == 0


needs_namespaces = pytest.mark.skipif(not _can_isolate(), reason="this account can make no mount namespaces")


def isolated(command: Sequence[object], shared: Sequence[Path], account: int | None = None) -> list[str]:
    """The command under the isolation of the unit; shared: folders that stay as they are, the emulated devices among
    them; account: number of another account that runs it."""
    service = unit_section()
    kept = [*shared, Path(sys.base_prefix), Path(sys.prefix), ROOT]
    lines = ["set -e", "mount --make-rprivate /", "mount -t tmpfs -o mode=755 tmpfs /mnt"]
    for number, folder in enumerate(kept):
        lines += [f"mkdir /mnt/{number}", f"mount --rbind {shlex.quote(str(folder))} /mnt/{number}"]
    if service["PrivateTmp"] == "yes":
        lines += [f"mount -t tmpfs -o mode=1777 tmpfs {folder}" for folder in ("/tmp", "/var/tmp")]
    if service["ProtectHome"] == "yes":
        lines += [f"mkdir -p {f}; mount -t tmpfs -o mode=755 tmpfs {f}" for f in ("/home", "/root", "/run/user")]
    for number, folder in enumerate(kept):
        place = shlex.quote(str(folder))
        lines += [f"mkdir -p {place}", f"mount --rbind /mnt/{number} {place}"]
    lines.append("umount -R -l /mnt")
    if service["ProtectSystem"] == "strict":
        lines.append("mount -o remount,bind,ro /")
    privileges = ["setpriv", "--no-new-privs"] if service["NoNewPrivileges"] == "yes" else []
    if account is not None:
        privileges = [*(privileges or ["setpriv"]), f"--reuid={account}", f"--regid={account}", "--clear-groups"]
    lines.append(f"exec {shlex.join([*privileges, *map(str, command)])}")
    return ["unshare", "--mount", "sh", "-c", "\n".join(lines)]
