"""A diagnosis in words: for the terminal and for the page."""

from __future__ import annotations

import math
from typing import NamedTuple

from rich import box
from rich.console import Console
from rich.table import Table

from platform_daemon.core.reporting.numbers import number
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.core.schemas.value_sources import value_sources_text
from platform_daemon.diagnosis.report_schema import (
    DiagnosisReport,
    EffectDetail,
    MeanParameter,
    MovingParameter,
    NamedEffect,
    NextMeasurement,
    TentativeEffect,
    TriedEffect,
)

VERDICTS = {
    "nothing_missing": "Nothing is missing: what is left over is noise.",
    "explained": "Explained: with the effects named here, what is left over is noise.",
    "partly_explained": "Partly explained: the effects named here predict better, but something is still left over.",
    "unexplained": "Unexplained: something is missing that no effect of the library accounts for.",
}
_LIKELY = 5  # rows of the ranking on the terminal


def strength_text(effect: NamedEffect) -> str:
    """1.02(3)e-5 1/rad."""
    found = effect.strength
    unit = "" if found.unit in ("", "1") else f" {found.unit}"
    return f"{scientific(found.value, found.std)}{unit}"


def scientific(value: float | None, std: float | None) -> str:
    """A value with its standard deviation, in powers of ten where it is small or large."""
    if value is None:
        return "-"
    exponent = math.floor(math.log10(abs(value))) if value else 0
    if -3 <= exponent < 4:
        return number(value, std, 1.0)
    return f"{number(value, std, 10.0**-exponent)}e{exponent:+d}"


def place_text(where: EffectDetail | TriedEffect) -> str:
    """Where an effect acts, in words; "" if that needs no saying."""
    of = where if isinstance(where, EffectDetail) else None
    std = (of.std if of else None) or {}
    parts = [
        f"on {where.axis}" if where.axis else "",
        f"from {of.source} to {of.target}" if of and (of.source or of.target) else "",
        "" if where.frequency_hz is None else f"at {where.frequency_hz:.5g} Hz",
        "" if where.tau_s is None else f"with a time constant of {_told(where.tau_s, std.get('tau_s'))} s",
        "" if of is None or of.sample is None else f"before sample {of.sample}",
        *(f"{k} = {_told(v, std.get(k))}" for k, v in (of.hidden_scales() if of else {}).items() if v is not None),
    ]
    return ", ".join(filter(None, parts))


def _told(value: float, std: float | None) -> str:
    """With its standard deviation where that is known and is no more than the value."""
    return scientific(value, std) if std is not None and 0.0 < std < abs(value) else f"{value:.5g}"


def chance_text(effect: NamedEffect) -> str:
    """The p-value, also where it is too small for a float."""
    log10 = effect.log10_p_value
    return f"p < 1e{math.ceil(log10)}" if log10 is not None and log10 < -300 else f"p = {plain(effect.p_value, '-')}"


def where_line(moved: MovingParameter) -> str:
    """One constant of the model that moves along the ring-down, and the quantity that it follows."""
    log10 = moved.log10_p_value
    chance = "" if log10 is None else f" (p < 1e{math.ceil(log10)})" if log10 < -4 else f" (p = {plain(moved.p_value)})"
    share = "" if moved.share is None else f"; it accounts for {100.0 * moved.share:.3g} % of the misfit"
    alike = f"; {' or '.join(definition_of(n).symbol for n in moved.alike)} would do as well" if moved.alike else ""
    return f"{definition_of(moved.name).symbol} moves along the ring-down{chance}, {_goes_with(moved)}{share}{alike}"


def _goes_with(moved: MovingParameter) -> str:
    """What a trace follows, in words."""
    names = {"amplitude": "the amplitude", "speed": "the peak speed", "time": "the time"}
    rises = "rises" if moved.rises else "falls"
    if not moved.follows:
        return f"it {rises} in all, by no simple law of amplitude, speed or time"
    how = "as time goes on" if moved.follows == ("time",) else "as the swing dies"
    return f"it follows {' or '.join(names[f] for f in moved.follows)} ({rises} {how})"


def effect_line(effect: NamedEffect) -> str:
    """One accepted effect."""
    place = place_text(effect.detail)
    text = f"{effect.id}{f' ({place})' if place else ''}: {strength_text(effect)}, {chance_text(effect)}"
    if effect.held_out_gain is None:
        text += ", without it held-out data cannot be predicted"
    elif effect.held_out_gain:
        text += f", held-out chi2 falls by {effect.held_out_gain:.4g}"
    alike = effect.indistinguishable_from
    return text + (f"; these data cannot tell it from {', '.join(alike)}" if alike else "")


def tentative_line(tentative: TentativeEffect) -> str:
    """One effect that gains but was not accepted, and why not."""
    effect = tentative.effect
    place = place_text(effect.detail)
    return f"{effect.id}{f' ({place})' if place else ''}: {strength_text(effect)}; {tentative.why_not}"


def held_out_line(report: DiagnosisReport) -> str:
    """Error of the prediction before and after."""
    h = report.held_out
    what = "the end of the one shot, predicted from its beginning" if h.n_shots == 1 else f"{h.n_shots} shots"
    return (
        f"held-out data ({what}): nRMSE {_percent(h.nrmse_before)} -> {_percent(h.nrmse_after)}, "
        f"chi2/dof {plain(h.chi2_per_dof_before)} -> {plain(h.chi2_per_dof_after)}"
    )


def plain(value: float | None, without: str = "no prediction") -> str:
    """Four digits; what is not finite is None in the JSON form."""
    return without if value is None else f"{value:.4g}"


def _percent(value: float | None) -> str:
    return "no prediction" if value is None else f"{100.0 * value:.4g} %"


def summary_text(report: DiagnosisReport) -> str:
    """For the terminal."""
    console = Console(width=150, markup=False, color_system=None)  # it is printed as plain text
    with console.capture() as capture:
        console.print(VERDICTS[report.verdict], highlight=False, style="bold")
        for line in _lines(report):
            console.print(line, highlight=False, markup=False)
        console.print(_parameters(report))
    return "\n".join(line.rstrip() for line in capture.get().rstrip().splitlines())


def _lines(report: DiagnosisReport) -> list[str]:
    lines = [f"where: {where_line(m)}" for m in report.where or ()]
    lines += [f"  {effect_line(e)}" for e in report.effects]
    lines += [f"  not accepted: {tentative_line(t)}" for t in report.tentative or ()]
    lines.append(held_out_line(report))
    if report.model_after is not None:
        lines.append(f"model after the diagnosis: {report.model_after}")
    if not report.effects and report.verdict != "nothing_missing":
        ranked = ", ".join(f"{t.id} (gain {plain(t.gain, '-')})" for t in report.ranking[:_LIKELY])
        lines.append(f"closest names beyond the declared model: {ranked}")
    lines += [f"integrity: {flaw.id}: {flaw.where}" for flaw in report.integrity]
    lines += [f"next: {next_line(n)}" for n in report.next_measurements[:_LIKELY]]
    lines += [f"note: {note}" for note in report.notes]
    for each in report.value_sources or ():
        lines += [f"{each.file}: {line}" for line in value_sources_text(each.value_sources).splitlines()]
    return [*lines, f"declared model {report.model}; {report.seconds:.3g} s of wall time"]


def next_line(proposal: NextMeasurement) -> str:
    """A proposed measurement."""
    separates = f" (separates {', '.join(proposal.separates)})" if proposal.separates else ""
    return f"{proposal.what}{separates}: {plain(proposal.expected_sigma, '?')} sigma expected"


def _parameters(report: DiagnosisReport) -> Table:
    """Means of the parameters before and after, and the disagreement of N50 and D30."""
    table = Table(box=box.SIMPLE_HEAD)
    for name in ("parameter (mean)", "before", "after", "scatter", "|N50 - D30| / σ before", "after"):
        table.add_column(name, justify="left" if name.startswith("parameter") else "right")
    for row in parameter_rows(report):
        table.add_row(*row[:4], sigma_text(row.sigma_before), sigma_text(row.sigma_after))
    return table


class ParameterRow(NamedTuple):
    """Name with unit, mean before and after, scatter between shots, as text; |N50 - D30| in standard errors."""

    heading: str
    before: str
    after: str
    scatter: str
    sigma_before: float | None
    sigma_after: float | None


def parameter_rows(report: DiagnosisReport) -> list[ParameterRow]:
    """A row for each parameter that is known before, after or by its disagreement."""
    before, after, sigma = report.parameters_before, report.parameters_after, report.n50_d30
    rows = []
    for name in before | after | sigma:
        shown, pair, scatter = definition_of(name), sigma.get(name), report.scatter.get(name)
        factor = shown.display_factor
        rows.append(
            ParameterRow(
                shown.heading,
                _mean(before.get(name), factor),
                _mean(after.get(name), factor),
                "-" if scatter is None else f"{scatter * factor:.2g}",
                None if pair is None else pair.before_sigma,
                None if pair is None else pair.after_sigma,
            )
        )
    return rows


def _mean(mean: MeanParameter | None, factor: float) -> str:
    return "-" if mean is None else number(mean.value, mean.std, factor)


def sigma_text(value: float | None) -> str:
    """One digit after the point."""
    return "-" if value is None else f"{value:.1f}"
