"""docs/evidence/wiring-campaign.md from a campaign's records."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from tests.campaigns.faults.wiring_trial import KINDS, LEAST_S, MOST_S, SEVERAL, TRICKLE, TRICKLE_S
from tests.campaigns.faults.wirings import WIRINGS

HEAD = """# Wirings of gate and receiver under faults

What faults about the TX window come to under each wiring that the page about [wiring](../reference/wiring.md)
allows, on the emulated lab: two I/O cards, serial switch and LNA, amplifier over USBTMC; the daemon's shot
above the real drivers, in a process of its own that can be made to stand still (SIGSTOP). Written by `make
wiring-campaign` (seed {seed}). The host stands still, or a wire falls silent, loses bytes or answers late,
for {least:g} to {most:g} s each, up to {several} times in a row, or samples trickle, {trickle} pieces late by
{short:g} to {long:g} ms each; at a time drawn at random from asking for the shot until RX; TX is 94 ms long.
A wiring that the page calls forbidden is refused before anything is opened
(`tests/system/emulated/test_wiring.py`).

After each it is checked, by the world's own record and not by that of the drivers, that power never met a connected
receiver or one that was moving there; that power reached the coils for no longer than TX and what the wiring allows
(a gate on the sequence: 1 ms; by the host: 1 s, and while the host stands still as long as
it does); that the shot ended; and, when the wires are mended, that outputs can be proved off and the next shot is good
without a hand, or that the error says what a hand must do.

**{blows} faults, {good} as it must be, {bad} not; power met the receiver {met} times.** A shot after a mended wire
was good at the first try in {first} of {mended}, else at a later one: this computer was busy, and late itself. {hand}
times a server hung, and the error said that it must be restarted.
From asking until told: {median:.1f} s (median), {longest:.0f} s (longest: a dead link is tried again before the
outputs are called unconfirmed).

| wiring | fault | shot good | refused | ended by an error | power beyond TX, longest | not as it must be |
|---|---|---|---|---|---|---|
"""


def text(records: Sequence[dict[str, Any]], seed: int) -> str:
    """The page."""
    times = sorted(r["told_s"] for r in records) or [0.0]
    bad = [r for r in records if r["complaints"]]
    head = HEAD.format(
        seed=seed,
        least=LEAST_S,
        most=MOST_S,
        several=SEVERAL,
        trickle=TRICKLE,
        short=1e3 * TRICKLE_S[0],
        long=1e3 * TRICKLE_S[1],
        blows=len(records),
        good=len(records) - len(bad),
        bad=len(bad),
        met=sum(any("power met" in c for c in r["complaints"]) for r in bad),
        first=sum(r["tries"] == 1 for r in records),
        mended=sum(r["tries"] > 0 for r in records),
        hand=sum(r["hand"] for r in records),
        median=times[len(times) // 2],
        longest=times[-1],
    )
    rows = [_row(w.name, kind, records) for w in WIRINGS for kind in KINDS]
    return (
        head + "\n".join(rows) + "\n" + "".join(f"\n* {r['index']}: {'; '.join(r['complaints'])[:300]}\n" for r in bad)
    )


def _row(wiring: str, kind: str, records: Sequence[dict[str, Any]]) -> str:
    mine = [r for r in records if (r["wiring"], r["kind"]) == (wiring, kind)]
    ends, over_s = Counter(r["ended"] for r in mine), max((r["over_s"] for r in mine), default=0.0)
    bad = sum(bool(r["complaints"]) for r in mine)
    return (
        f"| {wiring} | {kind} | {ends['good']} | {ends['refused']} | {ends['ended']} | {1e3 * over_s:.0f} ms | {bad} |"
    )
