"""A budget in words, and as a picture."""

from __future__ import annotations

import math

from matplotlib.figure import Figure

from platform_daemon.core.reporting.figures import COLOURS, new_figure, png_of
from platform_daemon.core.reporting.tables import Column, tables_text
from platform_daemon.core.schemas.parameters import definition_of

from .schema import BudgetReport, OffCentreReport

_MANY = 1e6  # degrees of freedom, whose k is that of infinitely many in all digits that are printed
_SHOWN = 1e-2  # of the combined standard uncertainty: smaller contributions are summed up in words


def budget_text(report: BudgetReport) -> str:
    """Result, a line for each contribution, and what is not declared."""
    shown = [line for line in report.inputs if line.contribution >= _SHOWN * report.u]
    unit = definition_of(report.quantity).unit
    unit = "" if unit == "1" else f" {unit}"
    result = f"{report.quantity} = {report.value:.10g}{unit}, U = {report.U:.2g}{unit} (k = {report.k:.2f}, "
    result += f"{report.coverage:.0%}); u = {report.u:.2g}{unit}, effective degrees of freedom: {dof_text(report)}"
    columns: list[Column] = [
        ("u", [f"{line.u:.3g}" for line in shown]),
        ("type", [line.type for line in shown]),
        ("distribution", [line.distribution for line in shown]),
        ("sensitivity", [f"{line.sensitivity:.4g}" for line in shown]),
        (f"contribution /{unit or ' 1'}", [f"{line.contribution:.3g}" for line in shown]),
    ]
    lines = [tables_text(result, ("input", [line.name for line in shown]), columns)]
    if rest := len(report.inputs) - len(shown):
        lines.append(f"{rest} more of less than {_SHOWN:.0%} of u each")
    for each in report.not_declared:
        adds = "what it adds is not known" if each.would_add_per_unit is None else f"adds {each.would_add_per_unit:.3g}"
        lines.append(f"not declared: {each.name}: {adds}{unit if each.would_add_per_unit is not None else ''}")
    if report.temperature is not None:
        lines.append(f"temperature: {report.temperature}")
    if report.monte_carlo is not None:
        lines.append(monte_carlo_line(report))
    return "\n".join(lines)


def dof_text(report: BudgetReport) -> str:
    """The effective degrees of freedom."""
    return "infinitely many" if report.dof is None or report.dof > _MANY else f"{report.dof:.1f}"


def rounded(report: BudgetReport) -> str:
    """value ± U, both to two digits of U (JCGM 100:2008, 7.2.6)."""
    digits = 1 - math.floor(math.log10(float(f"{report.U:.1e}"))) if report.U > 0.0 else 6
    return " ± ".join(f"{round(number, digits) + 0.0:.{max(0, digits)}f}" for number in (report.value, report.U))


def off_centre_line(found: OffCentreReport) -> str:
    """What the test says."""
    distance = "" if found.distance_m is None else f"{1e3 * found.distance_m:.2g} mm"
    if found.seen:
        return (
            f"off centre: the rotor stands at least {distance} from the centre of the coils "
            f"(p = {found.probability:.1g}); mount it in the centre, or calibrate where it stands"
        )
    return f"off centre: not seen (p = {found.probability:.2g})"


def monte_carlo_line(report: BudgetReport) -> str:
    """What the draws say of the law of propagation."""
    drawn = report.monte_carlo
    assert drawn is not None
    holds = "holds" if drawn.law_of_propagation_holds else "does not hold"
    sure = "" if drawn.conclusive else "; the draws are too few to be sure"
    return (
        f"Monte Carlo, {drawn.trials} draws: {drawn.low:.10g} to {drawn.high:.10g}; the law of propagation {holds} "
        f"within {drawn.tolerance:.1g}{sure}"
    )


def budget_png(report: BudgetReport) -> bytes:
    """The picture as PNG."""
    return png_of(draw_budget(report), 110)


def draw_budget(report: BudgetReport) -> Figure:
    """Bars of the contributions, the largest on top, and the combined standard uncertainty."""
    shown = [line for line in report.inputs if line.contribution >= _SHOWN * report.u][:15]
    figure = new_figure(8.0, 1.2 + 0.35 * (len(shown) + 1))
    axes = figure.subplots()
    names = [*(line.name for line in shown), "combined"]
    sizes = [*(line.contribution for line in shown), report.u]
    kinds = [*(COLOURS[0] if line.type == "A" else COLOURS[1] for line in shown), "0.3"]
    axes.barh(range(len(names)), sizes, color=kinds)
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.set_xlabel(f"contribution to u({report.quantity}) / {definition_of(report.quantity).unit}")
    axes.set_title("blue: type A, red: type B", fontsize=9)
    return figure
