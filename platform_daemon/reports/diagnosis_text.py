"""A diagnosis in words: for the terminal and for the top of the page. Made from its JSON form."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from platform_daemon.schemas import definition_of

from .numbers import number

VERDICTS = {
    "nothing_missing": "Nothing is missing: what is left over is noise.",
    "explained": "Explained: with the effects named here, what is left over is noise.",
    "partly_explained": "Partly explained: the effects named here predict better, but something is still left over.",
    "unexplained": "Unexplained: something is missing that no effect of the library accounts for.",
}
_LIKELY = 5  # rows of the ranking on the terminal


def heading_of(name: str) -> tuple[str, float]:
    """(name with the unit that is shown, factor from SI to it) of a parameter."""
    shown = definition_of(name)
    return shown.heading, shown.display_factor


def strength_text(effect: Mapping[str, Any]) -> str:
    """1.02(3)e-5 1/rad."""
    s = effect["strength"]
    unit = "" if s["unit"] in ("", "1") else f" {s['unit']}"
    return f"{scientific(s['value'], s['std'])}{unit}"


def scientific(value: float | None, std: float | None) -> str:
    """A value with its standard deviation, in powers of ten where it is small or large."""
    if value is None:
        return "-"
    exponent = math.floor(math.log10(abs(value))) if value else 0
    if -3 <= exponent < 4:
        return number(value, std, 1.0)
    return f"{number(value, std, 10.0**-exponent)}e{exponent:+d}"


def place_text(detail: Mapping[str, Any]) -> str:
    """Where an effect acts, in words; "" if that needs no saying."""
    known = dict(detail)
    parts = []
    if known.pop("axis", None):
        parts.append(f"on {detail['axis']}")
    if known.get("from") or known.get("to"):
        parts.append(f"from {known.get('from')} to {known.get('to')}")
    units = {"frequency_hz": ("at", "Hz"), "tau_s": ("with a time constant of", "s")}
    for name, (before, unit) in units.items():
        if known.get(name) is not None:
            parts.append(f"{before} {known[name]:.5g} {unit}")
    if known.get("sample") is not None:
        parts.append(f"before sample {known['sample']}")
    rest = {k: v for k, v in known.items() if k not in ("from", "to", "sample", *units) and v is not None}
    return ", ".join([*parts, *(f"{k} = {v:.4g}" for k, v in rest.items())])


def chance_text(effect: Mapping[str, Any]) -> str:
    """The p-value, also where it is too small for a float."""
    log10 = effect.get("log10_p_value")
    if log10 is not None and log10 < -300:
        return f"p < 1e{math.ceil(log10)}"
    return f"p = {plain(effect['p_value'], '-')}"


def effect_line(effect: Mapping[str, Any]) -> str:
    """One accepted effect."""
    place = place_text(effect["detail"])
    text = f"{effect['id']}{f' ({place})' if place else ''}: {strength_text(effect)}, {chance_text(effect)}"
    if effect["held_out_gain"] is None:
        text += ", without it held-out data cannot be predicted"
    elif effect["held_out_gain"]:
        text += f", held-out chi2 falls by {effect['held_out_gain']:.4g}"
    alike = effect["indistinguishable_from"]
    return text + (f"; these data cannot tell it from {', '.join(alike)}" if alike else "")


def held_out_line(report: Mapping[str, Any]) -> str:
    """Error of the prediction before and after."""
    h = report["held_out"]
    what = "the end of the one shot, predicted from its beginning" if h["n_shots"] == 1 else f"{h['n_shots']} shots"
    return (
        f"held-out data ({what}): nRMSE {_percent(h['nrmse_before'])} -> {_percent(h['nrmse_after'])}, "
        f"chi2/dof {plain(h['chi2_per_dof_before'])} -> {plain(h['chi2_per_dof_after'])}"
    )


def plain(value: float | None, without: str = "no prediction") -> str:
    """Four digits; what is not finite is None in the JSON form."""
    return without if value is None else f"{value:.4g}"


def _percent(value: float | None) -> str:
    return "no prediction" if value is None else f"{100.0 * value:.4g} %"


def summary_text(report: Mapping[str, Any]) -> str:
    """For the terminal."""
    console = Console(width=150)
    with console.capture() as capture:
        console.print(VERDICTS[report["verdict"]], highlight=False, style="bold")
        for line in _lines(report):
            console.print(line, highlight=False, markup=False)
        console.print(_parameters(report))
    return "\n".join(line.rstrip() for line in capture.get().rstrip().splitlines())


def _lines(report: Mapping[str, Any]) -> list[str]:
    lines = [f"  {effect_line(e)}" for e in report["effects"]]
    lines.append(held_out_line(report))
    if not report["effects"] and report["verdict"] != "nothing_missing":
        ranked = ", ".join(f"{t['id']} (gain {plain(t['gain'], '-')})" for t in report["ranking"][:_LIKELY])
        lines.append(f"closest names beside the declared model: {ranked}")
    lines += [f"integrity: {flaw['id']}: {flaw['where']}" for flaw in report["integrity"]]
    lines += [f"next: {next_line(n)}" for n in report["next_measurements"][:_LIKELY]]
    lines += [f"note: {note}" for note in report["notes"]]
    return [*lines, f"declared model {report['model']}; {report['seconds']:.3g} s"]


def next_line(proposal: Mapping[str, Any]) -> str:
    """A proposed measurement."""
    separates = f" (separates {', '.join(proposal['separates'])})" if proposal["separates"] else ""
    return f"{proposal['what']}{separates}: {plain(proposal['expected_sigma'], '?')} sigma expected"


def _parameters(report: Mapping[str, Any]) -> Table:
    """Means of the parameters before and after, and the disagreement of N50 and D30."""
    table = Table(box=box.SIMPLE_HEAD)
    for name in ("parameter (mean)", "before", "after", "scatter", "|N50 - D30| / σ before", "after"):
        table.add_column(name, justify="left" if name.startswith("parameter") else "right")
    for row in parameter_rows(report):
        table.add_row(*row)
    return table


def parameter_rows(report: Mapping[str, Any]) -> list[list[str]]:
    """Name, before, after, scatter between shots, N50-D30 before and after, as text."""
    before, after, sigma = report["parameters_before"], report["parameters_after"], report["n50_d30"]
    rows = []
    for name in dict.fromkeys([*before, *after, *sigma]):
        heading, factor = heading_of(name)
        pair = sigma.get(name, {})
        scatter = report["scatter"].get(name)
        rows.append([
            heading, _mean(before.get(name), factor), _mean(after.get(name), factor),
            "-" if scatter is None else f"{scatter * factor:.2g}",
            _sigma(pair.get("before_sigma")), _sigma(pair.get("after_sigma")),
        ])  # fmt: skip
    return rows


def _mean(mean: Mapping[str, float] | None, factor: float) -> str:
    return "-" if mean is None else number(mean["value"], mean["std"], factor)


def _sigma(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"
