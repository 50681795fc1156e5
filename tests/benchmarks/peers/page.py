"""docs/evidence/peers.md: a table per measured record, one of all simulated shots, every setting and seed."""

from __future__ import annotations

import math
import platform
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from statistics import median

from tests.benchmarks.peers import simulated
from tests.benchmarks.peers.columns import LIBRARY
from tests.benchmarks.peers.datasets import R4_UNTIL_S, START, TRAIN, measured
from tests.benchmarks.peers.routes import SHOT_BOXES, TRUE, Boxes, Row, routes

PACKAGES = ("pysindy", "pyoperon", "sysidentpy", "jax", "optax", "scikit-learn", "scipy", "numpy")
_RECORDS = {
    "r1": "a pendulum, encoder, 55 s",
    "r2": "a rotary pendulum, encoder: run 2 predicted from runs 1 and 3",
    "r4": f"the rig of r1, its last seconds (first {R4_UNTIL_S:g} s of the file: then it rests)",
    "r5a": "a rod hung from a magnet, filmed, 9 s (MartinRobomaze/eulers-pendulum, CC BY 4.0)",
    "r5b": "another such rod, 15 s (the same source)",
}


def document(rows: Sequence[Row]) -> str:
    """The page."""
    by = {(r.route, r.dataset): r for r in rows}
    names_of_rows = [r.name for r in routes(Boxes())]
    parts = [_INTRODUCTION]
    for dataset, what in _RECORDS.items():
        found = [by[n, dataset] for n in names_of_rows if (n, dataset) in by]
        if found:
            parts.append(f"## {dataset}: {what}\n\n{_measured(found)}")
    shots = sorted({r.dataset for r in rows if r.dataset not in _RECORDS})
    if shots:
        parts.append(_simulated(names_of_rows, by, shots))
    parts.append(_settings())
    if absent := _absent(names_of_rows, by, shots):
        parts[0] += f"\n\n**Not complete: {absent} pairs of a row and a recording were not run for this page.**"
    return "\n\n".join(parts) + "\n"


def _absent(routes_: Sequence[str], by: Mapping[tuple[str, str], Row], shots: Sequence[str]) -> int:
    """How many were not run: the true model is known of shots only."""
    asked = [(n, d) for d in (*_RECORDS, *shots) for n in routes_ if n != TRUE or d in shots]
    return sum(pair not in by for pair in asked)


_INTRODUCTION = f"""# Peers

What other tools make of the same recordings, by the same score. Written by `make peers`
(`tests/benchmarks/peers`); do not edit.

Held-out error: coefficients from the first {100 * TRAIN:.0f} % of a record, start state and zero offset (of dm/dt
the gains of the channels) fitted to the same {100 * TRAIN:.0f} % with the coefficients held, then **one
uninterrupted simulation** by scipy to the end; rms error over the standard deviation of the signal, both
over the last {1 - TRAIN:.0%}. r2: coefficients from runs 1 and 3, start from the first {100 * START:.0f} % of
run 2, the rest is scored. One code (`score.py`) does so for every row; a NAR model runs free by itself. 1
or more is no better than a constant. `diverges`: the simulation leaves every bound.

Unphysical: a loss (viscous, quadratic, cubic, dry) that feeds the motion. Seconds: of the processor, one
core, without imports and without the scoring. What is missing in the measured records nobody knows for
sure, so that nothing is counted as missed or false there."""


def error(value: float | None) -> str:
    """Three digits, or why not."""
    if value is None:
        return "no result"
    return "diverges" if not math.isfinite(value) or value > 100.0 else f"{value:.3g}"


def names(found: Iterable[str]) -> str:
    """With commas."""
    return ", ".join(found) or "-"


def _named(row: Row) -> str:
    return names(row.named) + (f" (or {names(row.alike)})" if row.alike else "")


def _table(head: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(line)} |" for line in [head, ["---"] * len(head), *lines])


def _measured(rows: Sequence[Row]) -> str:
    head = ("row", "start's part", "held out", "names beyond the declared", "unphysical", "seconds", "remark")
    return _table(head, [
        (r.route, error(r.train), error(r.held_out), _named(r), names(r.unphysical), f"{r.seconds:.1f}",
         textwrap.shorten(r.remark.replace("|", "\\|"), 100, placeholder=" ...") or "-")
        for r in rows
    ])  # fmt: skip


def missed(row: Row, truth: Sequence[str]) -> list[str]:
    """Hidden effects that are neither named nor among the look-alikes that were named with them."""
    return [n for n in truth if n not in (*row.named, *row.alike)]


def false(row: Row, truth: Sequence[str]) -> list[str]:
    """Names of what is not there; the look-alike of a hidden effect is none where the effect is said beside it."""
    excused = 1 if any(n in row.alike and n not in row.named for n in truth) else 0
    return [n for n in row.named if n not in truth][excused:]


_SUMMARY = (
    "row", "shots", "median held out", "worst", "no result or diverges", "named exactly", "missed", "false",
    "unphysical", "seconds",
)  # fmt: skip


def _simulated(routes_: Sequence[str], by: dict[tuple[str, str], Row], shots: Sequence[str]) -> str:
    truth = {s: () if (d := simulated.drawn(int(s[1:])))[1] == simulated.NOTHING else (d[1],) for s in shots}
    found = {n: [by[n, s] for s in shots if (n, s) in by] for n in routes_}
    summary = [(n, *_summary(rows, truth)) for n, rows in found.items() if rows]
    single = []
    for s in shots:
        variant, effect, strength = simulated.drawn(int(s[1:]))
        cells = [error(by[n, s].held_out) if (n, s) in by else "-" for n in routes_]
        ours = by.get((routes_[-1], s))
        said = "-" if ours is None else _named(ours) if ours.held_out is not None else ours.remark
        single.append((s, variant, effect, f"{strength:.3g}", *cells, said))
    return (
        f"## {len(shots)} simulated shots, dm/dt, a hidden effect or none\n\n{_HIDDEN}\n\n"
        f"{_table(_SUMMARY, summary)}\n\n"
        "Held-out error shot by shot; strengths in the units of [the list of effects]"
        "(../reference/configuration.md#effects-that-the-simulated-world-hides).\n\n"
        f"{_table(('shot', 'variant', 'hidden', 'strength', *routes_, 'ours names'), single)}"
    )


def _summary(rows: Sequence[Row], truth: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """One row's cells over all shots."""
    errors = [math.inf if r.held_out is None else r.held_out for r in rows]
    speaks = any(r.named for r in rows)
    lost, wrong = (sum(len(f(r, truth[r.dataset])) for r in rows) for f in (missed, false))
    exact = sum(set(r.named) == set(truth[r.dataset]) for r in rows)
    counts = (str(exact) if speaks else "-", str(lost), str(wrong) if speaks else "-")
    flawed = sum(bool(r.unphysical) for r in rows)
    gone = sum(not math.isfinite(e) for e in errors)
    seconds = median(r.seconds for r in rows)
    return (
        str(len(rows)), error(median(errors)), error(max(errors)), str(gone), *counts, str(flawed), f"{seconds:.1f}"
    )  # fmt: skip


_HIDDEN = f"""Made by `sim_backend`, thread (2 s) and jewel (1 s) in turn, noise of the paper; effect and strength drawn
with seed {simulated.SEED} (`simulated.py`): {simulated.SIGMA[0]:g} to {simulated.SIGMA[1]:g} times the
standard deviation with which one shot of 2 and 1.6 s shows the effect. The peers are given R and m_r as
`platform-daemon fit` finds them, and get phi by trapezoidal integration, a 40 Hz high-pass and a 2.5 kHz
low-pass, both without phase. Every second sample of the thread's shots is scored; the error cannot fall
below that of the true model, which is noise. Named exactly: the hidden effect and nothing else (nothing where there is
none); missed: not even among the look-alikes that the row itself declares; false: not there, a declared
look-alike excepted; rows without names miss every effect."""


def _settings() -> str:
    lines = [f"* **{r.name}**: {r.settings}" for r in routes(Boxes())]
    lines.append(
        f"* Time boxes: UDE {Boxes().network:g} s on an angle and {SHOT_BOXES.network:g} s on a shot, compilation "
        f"included; pyoperon {Boxes().formula:g} and {SHOT_BOXES.formula:g} s, "
        f"what is refitted {Boxes().refit:g} and {SHOT_BOXES.refit:g} s of the wall clock, then as far as it came."
    )
    lines.append(
        f"* The ten columns: {', '.join(LIBRARY)}. "
        "phi, phi', phi'' of an angle by Savitzky-Golay of order 5 over 0.1 period, of dm/dt 0.3 period."
    )
    versions = []
    for package in PACKAGES:
        try:
            versions.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            continue
    lines.append(f"* Python {platform.python_version()}, {', '.join(versions)}; one core, one thread.")
    lines.append(f"* Records: {', '.join(measured())} of tests/data/measured, whose README names sources and licences.")
    return "## Settings\n\n" + "\n".join(lines)
