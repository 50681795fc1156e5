"""docs/crash.md from the strikes of a campaign."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from platform_daemon.supervisor.watch import LEASE_S

from .strike import Came
from .strikes import HANG_S, KILL_S, LATE_S, STRIKES, Strike

HEAD = """# Deaths, hangs and cut links

Written by `make crash`; do not edit. A daemon (`platform-daemon serve`) measures shots of 0.45 s on the emulated lab: two cards over TCP, switch and LNA over serial lines, amplifier over
USBTMC. In TX, in RX or between two shots one of its processes is killed, halted or told to end, or a wire or a card fails. What is measured is the lab's own record.

* *power*: until no power could reach the coils: gate low, or amplifier off; 0 where none could anyway.
* *amplifier*: until it was disabled. *all*: until the cards had stopped and the receiver was disconnected as well.
* *missed*: what must not be: an output that stays on, a series that does not go on, a shot more than {late:g} s late, no fault on file. *met*: power met a connected receiver.

Times in s; median and longest. Promised: after a death the amplifier is disabled within {kill:g} s in the median, after a halt within {hang:g} s (the lease is {lease:g} s). A dead link is
noticed when its answer is due, and only then can anything be done about it; meanwhile a shot goes to its planned end by the card's own sequence.
The lab, the daemon and this command shared {cores} cores.

| strike | in | n | power | amplifier | all | most late | missed | met |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
"""


def text(done: Sequence[Came], cores: int) -> str:
    """The page."""
    head = HEAD.format(late=LATE_S, kill=KILL_S, hang=HANG_S, lease=LEASE_S, cores=cores)
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
        _times([d.power_s for d in done] if strike.must != "go on" else []),
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
