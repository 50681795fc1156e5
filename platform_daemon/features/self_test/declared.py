"""What two self-tests say of the gains between them, as a line of `[uncertainty]`."""

from __future__ import annotations

import json
import math
from collections.abc import Collection
from datetime import datetime
from pathlib import Path

from drivers.errors import InputError
from drivers.text_files import read_text_file
from drivers.validation import validated

from .schema import SelfTestReport

_LARGEST_DB = 400.0  # of an isolation; no converter hears so far
_FREQUENCY = 1e-3  # relative: between tones further apart a receive chain that is not flat would count as a change


def read_self_test(path: Path) -> SelfTestReport:
    """What `self-test --json` wrote.  Raises InputError."""
    try:
        found = validated(SelfTestReport, json.loads(read_text_file(path)), str(path))
        _check(found)
        return found
    except (OSError, ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        remedy = "give a file that `platform-daemon self-test --json` has written"
        raise InputError("is no result of a self-test", where=str(path), why=str(error), remedy=remedy) from None


def _check(found: SelfTestReport) -> None:
    """Raises ValueError for numbers that no self-test has measured."""
    if not (math.isfinite(found.frequency_hz) and found.frequency_hz > 0.0):
        raise ValueError(f"frequency_hz is {found.frequency_hz}, and must be positive")
    for coil, db in found.isolation_db.items():
        if not abs(db) < _LARGEST_DB:
            raise ValueError(f"isolation_db of {coil} is {db} dB")
    if found.date:
        datetime.fromisoformat(found.date)


def check_comparable(coils: Collection[str], frequency_hz: float, before: SelfTestReport, where: str) -> None:
    """Check before anything is driven that a self-test can be compared with an earlier one.

    coils: that are driven; frequency_hz: of the tones, Hz; where: of the earlier one.  Raises InputError for an earlier
    one of other coils, and for one at another frequency.
    """
    if set(coils) != before.isolation_db.keys():
        what = f"it is of the coils {', '.join(before.isolation_db) or 'none'}, not of {', '.join(coils)}"
        raise InputError(what, where=where, remedy="give a self-test of this platform")
    if abs(frequency_hz / before.frequency_hz - 1.0) > _FREQUENCY:
        what = f"its tones were of {before.frequency_hz:g} Hz, those of this one are of {frequency_hz:g} Hz"
        raise InputError(what, where=where, remedy="give a self-test at the same self_test.frequency_hz")


def gain_declaration(now: SelfTestReport, before: SelfTestReport, where: str) -> str:
    """TOML with `[uncertainty] gain`: by how much the gains have changed since an earlier self-test.

    The tone passes amplifier, open contacts and receiver, so that a change of the receiver's gain is one of the product
    unless the others undo it.  Nothing corrects for the change, which therefore counts as a whole: u is its root mean
    square over the coils, with as many degrees of freedom.  where: of the earlier one.  Raises InputError for tests
    that cannot be compared: of other coils, at another frequency, and a test with itself.
    """
    check_comparable(now.isolation_db, now.frequency_hz, before, where)
    changes = [10.0 ** ((before.isolation_db[coil] - now.isolation_db[coil]) / 20.0) - 1.0 for coil in now.isolation_db]
    u = math.sqrt(math.fsum(change**2 for change in changes) / len(changes))
    if u == 0.0:
        why = "noise makes any two differ, so that it is the same test"
        raise InputError("both tests have heard the same", where=where, why=why, remedy="give an earlier one")
    each = ", ".join(f"{coil} {change:+.2g}" for coil, change in zip(now.isolation_db, changes, strict=True))
    days = " and ".join(one.date[:10] if one.date else "an unknown day" for one in (before, now))
    source = f"change between the self-tests of {days} at {now.frequency_hz:.0f} Hz, with amplifier and switch ({each})"
    return (
        "# By `platform-daemon self-test`: for the platform file, or for `platform-daemon budget --uncertainty`.\n"
        f'[uncertainty]\ngain = {{ u = {u:.3g}, kind = "A", dof = {len(changes)}, source = "{source}" }}\n'
    )
