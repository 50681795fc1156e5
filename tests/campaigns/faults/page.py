"""docs/evidence/fault-campaign.md from a campaign's records."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from tests.campaigns.faults.catalogue import Cell, Outcome, cells
from tests.campaigns.faults.trial import OFF_WITHIN_S

HEAD = """# The fault campaign

What a fault of the devices or of their wires comes to, on the emulated lab: two I/O cards, serial switch and LNA,
amplifier over USBTMC, and the daemon's engine and store above the real drivers. Written by `make fault-campaign`
(seed {seed}, faults number {first} to {last}); the outcomes were written down in `tests/campaigns/faults/catalogue.py`
before the run. A fault strikes the answer to one command, one write of the data stream, or one shot, drawn at random
within its phase; then the lab is repaired and a clean shot is asked for, after a fault of a device with a self-test
before it.

After each fault it is checked, by the world's own record and not by that of the drivers, that power could reach the
coils for no longer than {off_within:g} s after it; that DACs, gate and amplifier are off; that power never met a
connected receiver; that every acknowledged shot is in the file, and that every good one is, to half an ADC code, what
the world's converters recorded; that the daemon lives and that the clean shot is good.

**{faults} faults, {expected} ended as expected, {bad} did not.** Longest time from a fault until power could no longer
reach the coils: {off:.3f} s. From asking until the daemon had reported: {median:.1f} s (median), {longest:.0f} s
(longest: a dead link is tried again before its device is called missing or the outputs unconfirmed). {late} trials
were repeated because the computer had let the process stand still for 0.25 s or more, or had not come to see the
receiver connected within the RX window of 0.6 s, which refuses a shot by itself. Where a dead LNA makes a shot
doubtful that another was to follow, "shot refused" means that the next one is refused before it is energised, too.
"""

LEGEND = """## Outcomes

{rows}

Kinds: `timeout` one answer never comes; `garbage` random bytes instead; `half_reply`; `disconnect` after byte n of an
answer; `slow_link` answers up to 0.2 s late; `one_way_link` the device hears and is not heard; `deaf_link` it is not
reached; the rest are faults of the devices (`sim_backend/world/faults.py`). `off` is the read-back after a shot that
was whole. TCP has a checksum for samples, the server's protocol none: garbage in the data stream strikes records.
"""

FOUND = """## What it found

Mended in driver or daemon, with a test each, not by another expectation:

* A relay that bounced into the RX window, and samples at the end of the converter's range, made good shots. The switch
  now says how long its contacts took (`MOVE?`), and such samples refuse the shot.
* Whether the receiver was connected in time was judged by the host's clock; now by the card's.
* Garbage as the first answer of a card kept the daemon from starting; it connects again.
* A status record made of other bytes (some were missing before it) could be taken for one that flags the samples only.
* An answer that came after a serial line had been reopened was taken for that of the next question.
* A self-test that was itself no good shot ended the series; it is made once more.
* After shots had been moved to disk beside the next shot, one was lost if that next one was refused in its first chunk.
* A card that obeyed and whose samples did not arrive was connected anew for so long that its outputs were told as
  unconfirmed; a stop is now proved by the command connection alone.
* Connections whose first answers had been lost were waited for as if the card stood still, and no new one was made.

Left out: `dropped_samples` of the simulated card, a recording that skips 64 samples and says nothing. A latched trip
stays until an operator resets it, `POST /devices/power_amplifier/reset`
([the REST API](../howto/rest-and-network.md)). All this is with gate and receiver on the card's sequence; the other
wirings are in [wiring-campaign.md](wiring-campaign.md).
"""

SHORT = {
    Outcome.NO_START: "no start",
    Outcome.BEFORE_POWER: "before power",
    Outcome.SELF_TEST: "self-test refuses",
    Outcome.SHOT_REFUSED: "shot refused",
    Outcome.STOPPED: "series ends",
    Outcome.VALID: "valid",
}


def text(records: Sequence[dict[str, Any]], seed: int) -> str:
    """The page."""
    good = [r for r in records if not r["complaints"]]
    times = sorted(r["told_s"] for r in records) or [0.0]
    numbers = sorted(r["index"] for r in records) or [0]
    head = HEAD.format(
        seed=seed,
        first=numbers[0],
        last=numbers[-1],
        off_within=OFF_WITHIN_S,
        faults=len(records),
        expected=len(good),
        bad=len(records) - len(good),
        off=max((r["off_s"] for r in records), default=0.0),
        median=times[len(times) // 2],
        longest=times[-1],
        late=sum(bool(r["late"]) for r in records),
    )
    legend = LEGEND.format(rows="\n".join(f"* **{short}**: {outcome}" for outcome, short in SHORT.items()))
    return "\n".join([head, legend, *_totals(records), "", *_table(records), "", FOUND, *_unexpected(records)])


def _totals(records: Sequence[dict[str, Any]]) -> list[str]:
    found = Counter((r["expected"], bool(r["complaints"])) for r in records)
    rows = [f"| {SHORT[o]} | {found[o, False]} | {found[o, True]} |" for o in Outcome]
    return ["| expected | as expected | not |", "|---|---|---|", *rows]


def _table(records: Sequence[dict[str, Any]]) -> list[str]:
    """Device and phase down, kinds across; expected outcome, and how many of how many ended so."""
    by_cell = {name: [r for r in records if r["cell"] == name] for name in {r["cell"] for r in records}}
    lines = [
        "## Device, phase and kind",
        "",
        "| device | phase | kinds | expected | as expected |",
        "|---|---|---|---|---|",
    ]
    groups: dict[tuple[str, str, str], list[Cell]] = {}
    for cell in cells():
        where = f"{cell.site.phase} ({cell.part})" if cell.part else cell.site.phase
        groups.setdefault((cell.device, where, SHORT[cell.expected.outcome]), []).append(cell)
    for (device, where, outcome), members in groups.items():
        done = [r for cell in members for r in by_cell.get(cell.name, [])]
        right = sum(not r["complaints"] for r in done)
        kinds = ", ".join(cell.kind for cell in members)
        lines.append(f"| {device} | {where} | {kinds} | {outcome} | {right} of {len(done)} |")
    return lines


def _unexpected(records: Sequence[dict[str, Any]]) -> list[str]:
    bad = [r for r in records if r["complaints"]]
    if not bad:
        return []
    return [
        "## Not as expected",
        "",
        *[f"* {r['index']} {r['cell']}: {'; '.join(r['complaints'])[:300]}" for r in bad],
        "",
    ]
