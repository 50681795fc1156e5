"""A diagnosis as one self-contained HTML page: words, tables and pictures; nothing is loaded from anywhere."""

from __future__ import annotations

import base64
import math
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from io import BytesIO
from typing import Any

import numpy as np
import scipy
from matplotlib.figure import Figure

from platform_daemon import __version__
from platform_daemon.diagnosis import (
    Diagnosis,
    ResidualAnalysis,
    Scatter,
    analyse_residual,
    scatter,
    shot_pool,
    sliding_windows,
    typical_shot,
)
from platform_daemon.estimation import SlidingFit

from .diagnosis_text import (
    VERDICTS,
    chance_text,
    effect_line,
    heading_of,
    held_out_line,
    next_line,
    parameter_rows,
    place_text,
    plain,
    scientific,
    strength_text,
)
from .figures import diagnosis as plots

_DPI = 100
_FEWEST_WINDOWS = 3  # that can be flat or not
_SHOWN = 8  # candidates at least, however unlikely
_STYLE = """
:root { color-scheme: light dark; --ink: light-dark(#1c2430, #e6e9ee); --page: light-dark(#ffffff, #15191f);
  --line: light-dark(#cfd6df, #3a434f); --soft: light-dark(#f2f5f8, #20262e); }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--page); max-width: 70rem;
  margin: 1.5rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin: 0 0 .3rem; } h2 { font-size: 1.15rem; margin: 2rem 0 .5rem;
  border-bottom: 1px solid var(--line); }
table { border-collapse: collapse; margin: .5rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .7rem; border-bottom: 1px solid var(--line); text-align: right; }
th:first-child, td:first-child, td.text, th.text { text-align: left; }
img { width: 100%; background: #fff; border: 1px solid var(--line); border-radius: 4px; margin: .4rem 0; }
.verdict { padding: .8rem 1rem; border-left: 6px solid; background: var(--soft); font-size: 1.1rem; }
.nothing_missing, .explained { border-color: #3a7d44; } .partly_explained { border-color: #c98a1b; }
.unexplained { border-color: #d1495b; } .wide { overflow-x: auto; } .small { font-size: .85rem; }
td.good { background: #3a7d4433; } td.fair { background: #c98a1b40; } td.poor { background: #d1495b55; }
@media print { body { max-width: none; margin: 0; } h2 { break-after: avoid; } img, tr { break-inside: avoid; } }
"""


@dataclass(frozen=True)
class ResidualAnalyses:
    """What the pictures are made of: (before, after) pairs."""

    shots: tuple[tuple[ResidualAnalysis, ResidualAnalysis], ...]
    sliding: tuple[str, SlidingFit, SlidingFit] | None
    scatter: tuple[tuple[Scatter, ...], tuple[Scatter, ...]]


def diagnosis_html(found: Diagnosis, report: Mapping[str, Any]) -> bytes:
    """The page in UTF-8; report: the diagnosis in its JSON form, with the files."""
    seen = residual_analyses(found)
    unit = "rad" if found.shots[0].record.quantity == "angle" else "A m^2/s"
    f_nat_hz = float(np.mean([s.dynamics.w for s in found.found.base.states])) / (2.0 * math.pi)
    parts = [
        _head(report),
        _effects(report),
        *_residuals(seen, unit, f_nat_hz),
        *_courses(seen),
        _parameters(report),
        *_torque(found),
        _ranking(report),
        _integrity(report),
        _how(found, report),
    ]
    title = escape(f"Diagnosis: {report['verdict'].replace('_', ' ')}")
    head = f'<meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{title}</title>'
    page = (
        f'<!doctype html><html lang="en"><head>{head}<style>{_STYLE}</style></head><body>{"".join(parts)}</body></html>'
    )
    return page.encode()


def residual_analyses(found: Diagnosis) -> ResidualAnalyses:
    """Of the first and a typical shot."""
    before, after = found.found.base, found.final
    typical = typical_shot(before)
    chosen = tuple(dict.fromkeys([0, typical]))
    with shot_pool() as pool:
        pairs = list(pool.map(lambda k: (analyse_residual(before, k), analyse_residual(after, k)), chosen))
        slides = list(pool.map(lambda at: sliding_windows(at, typical), (before, after)))
        courses = scatter(before, pool), scatter(after, pool)
    one, two = slides
    sliding = None
    if one is not None and two is not None and len(one.windows) >= _FEWEST_WINDOWS:
        sliding = before.started[typical].shot.name, one, two
    return ResidualAnalyses(tuple(pairs), sliding, courses)


def _section(title: str, *content: str) -> str:
    return f"<section><h2>{escape(title)}</h2>{''.join(content)}</section>"


def _paragraph(text: str, kind: str = "") -> str:
    return f'<p class="{kind}">{escape(text)}</p>'


def _list(lines: Iterable[str]) -> str:
    return f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in lines)}</ul>"


def _ungraded(cell: str, column: int) -> str:
    return ""


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]], grade: Callable[[str, int], str] = _ungraded) -> str:
    """grade: (cell, column) -> class."""
    head = "".join(f"<th>{escape(h)}</th>" for h in headings)
    lines = [[f'<td class="{grade(c, i)}">{escape(c)}</td>' for i, c in enumerate(row)] for row in rows]
    body = "".join(f"<tr>{''.join(line)}</tr>" for line in lines)
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>'


def _picture(figure: Figure, text: str) -> str:
    """As data, so that the page needs no other file."""
    buffer = BytesIO()
    figure.savefig(buffer, dpi=_DPI, format="png")
    data = base64.b64encode(buffer.getvalue()).decode()
    return f'<img alt="{escape(text, quote=True)}" src="data:image/png;base64,{data}">'


def _head(report: Mapping[str, Any]) -> str:
    files = ", ".join(f.rpartition("/")[2] for f in report["files"])
    said = VERDICTS[report["verdict"]]
    title = f"<h1>{escape(files)}</h1>"
    words = f'<p class="verdict {report["verdict"]}"><b>{escape(said)}</b><br>{escape(held_out_line(report))}</p>'
    return f"<header>{title}{_paragraph('Declared model: ' + report['model'], 'small')}{words}</header>"


def _effects(report: Mapping[str, Any]) -> str:
    effects = _list(effect_line(e) for e in report["effects"]) if report["effects"] else ""
    notes = _list(report["notes"]) if report["notes"] else ""
    measurements = "<p>Next measurements, the best first:</p>" + _list(map(next_line, report["next_measurements"]))
    return effects + notes + (measurements if report["next_measurements"] else "")


def _residuals(seen: ResidualAnalyses, unit: str, f_nat_hz: float) -> Iterable[str]:
    """In time, by frequency, by harmonic."""
    yield _section(
        "What is left over, in time",
        *(_picture(plots.draw_residual(p, unit), f"residual of {p[0].name} before and after") for p in seen.shots),
        _table(
            (
                "shot",
                "channel",
                "χ²/sample before",
                "after",
                "below 6.5 f before",
                "after",
                "first 20 ms before",
                "after",
            ),
            [row for pair in seen.shots for row in _whiteness(pair, unit)],
        ),
        _paragraph("1 is what the noise alone gives; it is measured in blank shots or beside the signal.", "small"),
    )
    typical = seen.shots[-1]
    yield _section(
        "What is left over, by frequency",
        _picture(plots.draw_spectra(typical, unit, f_nat_hz), "spectra of the residual before and after"),
    )
    before, after = typical[0].harmonics, typical[1].harmonics
    if before is not None and after is not None:
        drawn = plots.draw_harmonics(before, after, unit, typical[0].name)
        yield _section("What is left over, by harmonic", _picture(drawn, "harmonics of the residual"))


def _whiteness(pair: tuple[ResidualAnalysis, ResidualAnalysis], unit: str) -> Iterable[list[str]]:
    one, two = pair
    for c, name in enumerate(plots.channel_names(one.sd.size, unit)):
        numbers = [x[c] for a, b in zip(_levels(one), _levels(two), strict=True) for x in (a, b)]
        yield [one.name, name, *(f"{x:.4g}" for x in numbers)]


def _levels(one: ResidualAnalysis) -> tuple[Any, Any, Any]:
    return one.whiteness, one.in_band, one.at_start


def _courses(seen: ResidualAnalyses) -> Iterable[str]:
    """Sliding windows, shot to shot."""
    if seen.sliding is not None:
        name, before, after = seen.sliding
        yield _section(
            "Window by window",
            _paragraph("With a complete model these lines are flat."),
            _picture(plots.draw_sliding_pair(before, after, name), "fits of sliding windows"),
        )
    if seen.scatter[0]:
        yield _section(
            "Shot to shot",
            _picture(plots.draw_scatter(*seen.scatter), "parameters of every shot"),
            _table(("parameter", "scatter before", "after", "drift per shot after"), _drifts(*seen.scatter)),
        )


def _drifts(before: Sequence[Scatter], after: Sequence[Scatter]) -> Iterable[list[str]]:
    known = {s.name: s for s in after}
    for one in before:
        two = known.get(one.name, one)
        heading, factor = heading_of(one.name)
        spread = [f"{s.values.std(ddof=1) * factor:.3g}" for s in (one, two)]
        sd = two.drift_sd * factor
        yield [heading, *spread, scientific(two.drift_per_shot * factor, None if math.isnan(sd) else sd)]


def _grade(cell: str, column: int) -> str:
    """Colour of a disagreement in standard errors."""
    if column < 4 or cell == "-":
        return ""
    return "good" if float(cell) < 2.0 else "fair" if float(cell) < 4.0 else "poor"


def _parameters(report: Mapping[str, Any]) -> str:
    headings = ("parameter (mean)", "before", "after", "scatter", "|N50 − D30| / σ before", "after")
    words = "The last columns: how far fits of the first 0.24 s (N50) and of the decay to 30 % (D30) disagree."
    return _section(
        "Parameters, and N50 against D30", _table(headings, parameter_rows(report), _grade), _paragraph(words)
    )


def _torque(found: Diagnosis) -> Iterable[str]:
    if found.torque is not None:
        words = "Smooth in angle and velocity, and without what the declared parameters absorb."
        yield _section(
            "The missing torque", _paragraph(words), _picture(plots.draw_torque(found.torque), "the missing torque")
        )


def _ranking(report: Mapping[str, Any]) -> str:
    accepted = [
        [
            e["id"], place_text(e["detail"]), strength_text(e), chance_text(e),
            plain(e["held_out_gain"], "no prediction without it"), ", ".join(e["indistinguishable_from"]) or "-",
            e["source"],
        ]
        for e in report["effects"]
    ]  # fmt: skip
    tried = [
        [
            t["id"], place_text({k: t[k] for k in ("axis", "frequency_hz", "tau_s")}), plain(t["gain"], "-"),
            plain(t["p_value"], "-"), "allowed" if t["sign_allowed"] else "not physical",
        ]
        for k, t in enumerate(report["ranking"])
        if (t["p_value"] or 0.0) < 0.5 or k < _SHOWN
    ]  # fmt: skip
    headings = ("accepted", "where", "strength", "chance", "held-out gain", "look-alikes", "source")
    first = _table(headings, accepted) if accepted else _paragraph("No effect was accepted.")
    second = _table(("candidate alone", "where", "fall of χ²", "chance", "sign"), tried)
    words = "Every candidate by itself beside the declared model; chances are corrected for all that were tried."
    return _section("Ranking and evidence", first, _paragraph(words), second)


def _integrity(report: Mapping[str, Any]) -> str:
    rows = [[flaw["id"], flaw["where"]] for flaw in report["integrity"]]
    content = _table(("flaw", "where"), rows) if rows else _paragraph("No flaw was seen in the data.")
    return _section("Integrity of the data", content)


def _how(found: Diagnosis, report: Mapping[str, Any]) -> str:
    shots = [
        [
            s.shot.name, f"{s.time_s[-1] - s.time_s[0]:.4g} s", f"{s.shot.rate_hz:.6g} Hz", s.shot.noise.source,
            f"{np.median(s.shot.noise.sd):.3g}",
        ]
        for s in found.final.started
    ]  # fmt: skip
    libraries = f"Python {platform.python_version()}, numpy {np.__version__}, scipy {scipy.__version__}"
    when = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return _section(
        "How it was computed",
        _paragraph(f"platform-daemon {__version__}, {libraries}; {report['seconds']:.3g} s; {when}."),
        _list(report["files"]),
        _table(("shot", "window", "sampling rate", "noise measured from", "noise, sd of a sample"), shots),
    )
