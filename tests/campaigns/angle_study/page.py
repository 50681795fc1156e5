"""The study as a page of the documentation."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence

from tests.campaigns.angle_study.cases import SIGMAS
from tests.campaigns.angle_study.score import RATIO, VISIBLE, Score

_HEAD = """# Does the diagnosis name what angle records lack?

{count} of {asked} synthetic angle records of seed {seed}, made by `scipy.integrate.solve_ivp` (DOP853, from turning
point to turning point where friction is dry) in `tests/campaigns/angle_study`, which for the truth imports nothing of
this project; diagnosed by `platform-daemon diagnose FILE` with no option. 5 s or 100 to 120 s, 100 Hz to 10 kHz, 8 to
16 bit over +- pi or +- 1.2 amplitudes, 0.1 to 2 counts of white noise, f0 0.5 to 8 Hz, 0.3 to 2 rad. Written by
`make angle-study`; do not edit. `--record K` repeats record K.

Visibility (sigma): root of the fall of chi^2 from the best least-squares fit without the effect (start, f0, lambda and
zero free; Stribeck friction: also its Coulomb part; two effects: with the other one free, the less visible counts) to
the truth, in units of the true noise (white and quantum^2/12). "Alike": the same if the errors of neighbouring samples,
which the quantisation makes alike, are counted as they are. Of gaps: of the gap alone; "near" within three periods.

Right: every effect named (exact), or in the declared set of one that is (inside). Extra: besides, a name that is not
there; wrong: such a name without the right ones. "Against it": visibility of what the best fit with the names that were
said leaves of the truth. Outside the library (a drift of the zero unless that is named): no name, and not
`nothing_missing`. Held out: error of the last 30 % after the diagnosis over that of the true model, fitted by scipy to
the first 70 %; of a record that comes to rest the windows differ, and so the ratio says nothing.
"""
_FAULTS = ("extra", "wrong", "missed", "refused", "traceback", "slow")


def document(scores: Sequence[Score], asked: int, seed: int) -> str:
    """The whole page."""
    parts = [_HEAD.format(count=len(scores), asked=asked, seed=seed), _sums(scores), _table(scores), _wrong(scores)]
    return "\n".join(parts)


def _sums(scores: Sequence[Score]) -> str:
    seen = [s for s in scores if s.sigma >= 0.9 * VISIBLE or s.case in ("viscous", "gap")]
    ratios = [s.ratio for s in scores if s.ratio is not None]
    lines = [
        f"* named rightly or inside the declared set: {_share(sum(s.right for s in seen), len(seen))}",
        f"* false gaps in {sum(s.false_gaps > 0 for s in scores)} records, missed gaps in "
        f"{sum(s.missed_gaps > 0 for s in scores)}, false clipping in {sum(s.clipping for s in scores)}, "
        f"tracebacks {sum(s.result == 'traceback' for s in scores)}, "
        f"refused {sum(s.result == 'refused' for s in scores)}, "
        f"not done in time {sum(s.result == 'slow' for s in scores)}",
        f"* held-out error within {RATIO} times that of the true model: "
        f"{_share(sum(r <= RATIO for r in ratios), len(scores))}; negative losses in "
        f"{sum(bool(s.negative) for s in scores)}",
    ]
    if scores:
        times = sorted(s.seconds for s in scores)
        lines.append(f"* {statistics.median(times):.0f} s in the median, {times[-1]:.0f} s at most, "
                     f"{max(s.memory_mb for s in scores):.0f} MB at most")  # fmt: skip
    return "\n".join(lines) + "\n"


def _share(some: int, of: int) -> str:
    return f"{some} of {of} ({100.0 * some / max(of, 1):.0f} %)"


def level(score: Score) -> str:
    """Its column of the visibility."""
    if score.case in ("viscous", "stuck", "gap") or score.sigma <= 0.0:
        return "-"
    if score.sigma < 0.88 * SIGMAS[0]:
        return f"< {SIGMAS[0]:g}"
    return f"{min(SIGMAS, key=lambda s: abs(math.log(s / score.sigma))):g}"


def _table(scores: Sequence[Score]) -> str:
    lines = [
        "| case | sigma | records | exact | inside | " + " | ".join(_FAULTS) + " | false gaps | missed gaps "
        "| held out, median and worst | s, median and worst |",
        "|---" * 15 + "|",
    ]
    groups = {(s.case, level(s)) for s in scores}
    for case, sigma in sorted(groups, key=lambda g: (g[0], float(g[1]) if g[1][0].isdigit() else 0.0)):
        of = [s for s in scores if (s.case, level(s)) == (case, sigma)]
        counts = [sum(s.result == r for s in of) for r in ("exact", "inside", *_FAULTS)]
        ratios = [s.ratio for s in of if s.ratio is not None]
        held = f"{statistics.median(ratios):.3g}, {max(ratios):.3g}" if ratios else "-"
        times = [s.seconds for s in of]
        cells = [case, sigma, len(of), *counts, sum(s.false_gaps for s in of), sum(s.missed_gaps for s in of), held,
                 f"{statistics.median(times):.0f}, {max(times):.0f}"]  # fmt: skip
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines) + "\n"


def _wrong(scores: Sequence[Score]) -> str:
    bad = [s for s in scores if not s.right or s.flaws]
    lines = ["## What is not right, record by record", "", "| record | case | sigma, alike | result | verdict | says | "
             "cannot tell from | against it | flaws | what it is |", "|---" * 10 + "|"]  # fmt: skip
    return "\n".join([*lines, *(row(s) for s in bad)]) + "\n"


def row(s: Score) -> str:
    """One line."""
    told = ", ".join(dict.fromkeys(s.names)) or s.said.replace("|", "/") or "-"
    alike = ", ".join(dict.fromkeys(s.alike)) or "-"
    gaps = "".join(f"; gap of {g[1]:g} before {g[0]:g} ({g[2]:.0f}, near {g[3]:.0f})" for g in s.gaps)
    gaps += "".join(f"; told {lost:.4g} before {at:g}" for at, lost in s.gaps_told)
    flaws = "; ".join(s.flaws) or "-"
    against = "-" if s.against is None else f"{s.against:.1f}"
    return (f"| {s.index} | {s.case} | {s.sigma:.3g}, {s.seen_sigma:.3g} | {s.result} | {s.verdict or '-'} | {told} "
            f"| {alike} | {against} | {flaws} | {s.what}{gaps} |")  # fmt: skip
