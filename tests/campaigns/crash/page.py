"""docs/evidence/crash.md from the strikes of a campaign."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from platform_daemon.core.guard.watch import LEASE_S
from tests.campaigns.crash.strike import Came
from tests.campaigns.crash.strikes import HANG_S, KILL_S, LATE_S, STOP_HANG_S, STRIKES, Strike

HEAD = Path(__file__).with_name("page.txt")


def text(done: Sequence[Came], cores: int) -> str:
    """The page."""
    promised = {"late": LATE_S, "kill": KILL_S, "hang": HANG_S, "stop_hang": STOP_HANG_S, "lease": LEASE_S}
    head = HEAD.read_text().format(**promised, cores=cores)
    rows = [_row(each, [d for d in done if d.name == each.name]) for each in STRIKES]
    said = sorted({f"* {d.name}, in {d.moment}: {why}" for d in done for why in d.missed})
    bad = [*said, *(f"* {over}" for over in too_slow(done))]
    total = f"\n{len(done)} strikes.\n"
    return head + "\n".join(rows) + "\n" + total + ("\n## Missed\n\n" + "\n".join(bad) + "\n" if bad else "")


def too_slow(done: Sequence[Came]) -> list[str]:
    """Strikes whose median is above what is promised."""
    out = []
    for each in STRIKES:
        times = [d.amplifier_s for d in done if d.name == each.name and d.amplifier_s is not None]
        if each.must == "off" and times and np.median(times) > each.median_s:
            out.append(f"{each.name}: amplifier disabled after {np.median(times):.3f} s, promised {each.median_s:g} s")
    return out


def _row(strike: Strike, done: Sequence[Came]) -> str:
    columns = (
        _times([d.power_s for d in done]),
        _times([d.amplifier_s for d in done]),
        _times([d.all_s for d in done]),
    )
    late = max((d.late_s for d in done if d.late_s is not None), default=None)
    counts = sum(bool(d.missed) for d in done), sum(d.met for d in done)
    moments = ", ".join(strike.moments)
    shown = "-" if late is None else f"{late:.2f}"
    return f"| {strike.name} | {moments} | {len(done)} | {' | '.join(columns)} | {shown} | {counts[0]} | {counts[1]} |"


def _times(values: Sequence[float | None]) -> str:
    known = [v for v in values if v is not None]
    return f"{np.median(known):.3f}, {max(known):.3f}" if known else "-"
