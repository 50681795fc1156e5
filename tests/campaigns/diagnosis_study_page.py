"""The study of the diagnosis as a page of the documentation."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

if TYPE_CHECKING:
    from tests.campaigns.diagnosis_study import Outcome

Visible = Callable[[str, str, int], Mapping[tuple[Any, ...], float]]


SAMPLE_SD = 0.02  # A m^2/s, of the noise of a sample, about the middle of the three channels
RATE_HZ = 61035.0
_CANDIDATES = 60.0  # chances are corrected for about so many
# Standard deviations: 4.35 pass the corrected level of 1e-3, 1.65 more give 95 % power, held-out data must agree.
# Of 74 drawn at 5 and 74 at 6, 53 % and 77 % were found, which lies on a (probit) line through 95 % at 7.4.
_FOUND = 7.5
_LARGEST = {
    "channel_gain": 0.05,
    "channel_delay": 1e-4,
    "receive_lowpass": 1e-4,
    "crosstalk": 0.05,
    "receiver_compression": 1.0,
}
_LIMITS = """Strength in the effect's unit (frequency drift relative, in 1/s; Stribeck friction at the velocity scale
named) that is found in 95 of 100 cases: {sigma:g} standard deviations of the score test beside the declared parameters,
shots as in the study; the shares found at 5 and 6 sigma, above, were drawn, and this lies on the line through them.
Additive signals are searched for at any frequency or decay time: its limits allow for the number of these. A
whole sample lost from one shot is always seen (its place is known to 0.04 samples).
"""


def limits(visible: Visible) -> str:
    """Smallest strengths found with 95 % power in 1, 10 and 100 shots, from the score test's standard deviation."""
    rows = ["", "## Detection limits", "", _LIMITS.format(sigma=_FOUND)]
    rows += ["| variant | effect | 1 shot | 10 shots | 100 shots |", "|---|---|---|---|---|"]
    for variant in ("thread", "jewel"):
        for (name, *where), sd in visible(variant, "as mounted", 1).items():
            if name in ("f_nat_hz", "window_s", "tau_s") or not sd < _LARGEST.get(name, math.inf):
                continue
            place = " ".join(str(w) for w in where if w is not None)
            sizes = [_FOUND * sd / math.sqrt(shots) for shots in (1, 10, 100)]
            sizes = [math.sqrt(s) for s in sizes] if (name, *where) == ("receive_lowpass", None, None) else sizes
            rows.append(f"| {variant} | {name} {place} | " + " | ".join(f"{s:.2g}" for s in sizes) + " |")
        rows += _beside(variant, visible(variant, "as mounted", 1)["window_s", None, None])
    return "\n".join(rows) + "\n"


def _beside(variant: str, window_s: float) -> list[str]:
    """What stands beside the signal, in A m^2/s; `directions` of it are fitted in one shot, or in all together."""
    samples = window_s * RATE_HZ
    each = SAMPLE_SD * math.sqrt(2.0 / samples)  # of the amplitude of a tone over the whole window
    found = (
        ("mains_interference, spectral_line (one, on one channel)", each, 6, False, 0.5 * samples),
        ("side_mode 0.3 s (one channel)", each * math.sqrt(2.0 * window_s / 0.3), 6, True, 4.0 * samples),
        ("switch_transient 0.01 s (one channel)", each * math.sqrt(window_s / 0.01), 1, True, 14.0),
    )
    rows = []
    for name, sd, directions, shared, places in found:
        sizes = [
            sd / math.sqrt(shots) * needed(directions * (1 if shared else shots), places * _CANDIDATES)
            for shots in (1, 10, 100)
        ]
        rows.append(f"| {variant} | {name} | " + " | ".join(f"{s:.2g}" for s in sizes) + " |")
    return [*rows, f"| {variant} | clock_gap | 1 sample | 1 sample | 1 sample |"]


def needed(directions: int, trials: float) -> float:
    """Standard deviations at which something in so many directions is found with 95 % power among so many trials."""
    threshold = float(chi2.isf(1e-3 / trials, directions))
    size = brentq(lambda power: float(ncx2.sf(threshold, directions, power)) - 0.95, 1e-3, 10.0 * threshold + 100.0)
    return math.sqrt(float(size))


def row(outcome: Outcome) -> str:
    """One line of the table."""
    case = outcome.case
    name = (
        " + ".join(
            e["id"]
            + (f" {e['axis']}" if "axis" in e else "")
            + (" settling" if "frequency" in e["id"] and "tau_s" in e else "")
            for e in case.effects
        )
        or "nothing"
    )
    said = ", ".join(outcome.names) or "-"
    alike = ", ".join(outcome.alike) or "-"
    mark = "yes" if outcome.right else "**wrong**" if outcome.wrong else "told" if outcome.noted else "**no**"
    parameter, sigma = outcome.worst
    return (
        f"| {case.variant} | {case.pose} | {name} | {case.sigma:g} | {mark} | {outcome.verdict} | {said} | {alike} "
        f"| {outcome.chi2_after:.4f} | {parameter} {sigma:.1f} |"
    )


_HEAD = """# Does the diagnosis name what is missing?

Simulated recordings of {shots} shots with effects that were not declared to the diagnosis, made by `sim_backend`, whose
effect code is its own. Strength: drawn at random around multiples of the standard deviation with which the score test
sees the effect beside the declared parameters of all shots. Nameless effects (memory torques, a gap that breathes, a
second mode that beats) are in no list of candidates; right is every verdict but `explained`. Written by
`make diagnose-study` (`python -m tests.campaigns.diagnosis_study {options}`); do not edit.

Not applicable: effects whose strength would have to be implausible to be seen in a pose (a channel that hears nothing),
Stribeck friction without a jewel, Hertz friction beside the jewel's own.

Parameters: share of the recordings whose effects are named exactly in which every parameter lies within 3 of its
standard deviations of the truth, without those that the effects absorb whatever their size (m_r beside a gain, R beside
crosstalk, psi and phi_max beside a delay, f_nat beside a torsion); in the rows, the parameter farthest off.

Noted: an effect that gains little beside what the named ones gain is not named, because it may only mend their
shape; a note says that it is there, by how much, and the errors of the parameters span it. The strength of a weak
effect is what it has alone: where a strong one moves f_nat away from the drive the swing is small, and the weak one
may show nothing.

| undeclared | strength | cases | named or in its set | or noted | a wrong name | worst chi2/dof after | parameters |
|---|---|---|---|---|---|---|---|
"""
_TABLE = """
| variant | pose | effect | sigma | right | verdict | says | cannot tell it from | chi2/dof after | farthest, sd |
|---|---|---|---|---|---|---|---|---|---|
"""
_KINDS = {
    "uneven": "a strong effect beside a weak one",
    "one": "one effect",
    "two": "two effects",
    "nameless": "a nameless effect",
    "clean": "nothing",
}


def _options(given: Sequence[str]) -> str:
    """Of the command, without the files it wrote."""
    kept, words = [], iter(given)
    for word in words:
        if word in ("--journal", "--out"):
            next(words, None)
        else:
            kept.append(shlex.quote(word))
    return " ".join(kept)


def document(outcomes: Sequence[Outcome], shots: int, asked: int) -> str:
    """The study as a page."""
    lines = []
    for kind, sigma in sorted({(o.case.kind, o.case.sigma) for o in outcomes}):
        of = [o for o in outcomes if (o.case.kind, o.case.sigma) == (kind, sigma)]
        worst = max((o.chi2_after for o in of), key=lambda c: abs(c - 1.0))
        exact = [o for o in of if o.exact]
        near = f"{sum(o.worst[1] <= 3.0 for o in exact)} of {len(exact)}" if exact else "-"
        size = f"{sigma:g} sigma" if sigma else "-"
        right, wrong = sum(o.right for o in of), sum(o.wrong for o in of)
        told = sum(o.right or o.noted for o in of)
        lines.append(f"| {_KINDS[kind]} | {size} | {len(of)} | {right} | {told} | {wrong} | {worst:.4f} | {near} |")
    rows = [row(o) for o in outcomes]
    head = _HEAD.format(shots=shots, options=_options(sys.argv[1:]))
    if len(outcomes) < asked:
        head = head.replace("\n\n", f"\n\n**Stopped after {len(outcomes)} of {asked} recordings.**\n\n", 1)
    return head + "\n".join(lines) + "\n" + _TABLE + "\n".join(rows) + "\n"
