"""`platform-daemon budget`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.options import (
    CalibrationOption,
    HtmlOption,
    ModelsOption,
    TableOptions,
    VariantOption,
    WindowOption,
    calibration_in,
)
from platform_daemon.core.command_line.output import must_not_exist, say_note, write_json, write_page
from platform_daemon.core.command_line.request_options import option_groups
from platform_daemon.features.models.options import variant_named

_ALL = "all"


@option_groups
def budget(
    *,
    file: Annotated[Path, typer.Argument(help="Recording.")],
    quantity: Annotated[str, typer.Option(help="Parameter, as m_r_am2; all: every one.")] = "f_nat_hz",
    shot: Annotated[int | None, typer.Option(min=0, help="One frame, from 0; default: see --series.")] = None,
    series: Annotated[
        bool, typer.Option("--series", help="The mean of all shots; default where there are two.")
    ] = False,
    coverage: Annotated[float, typer.Option(help="Probability of the interval value ± U.")] = 0.95,
    uncertainty: Annotated[
        Path | None,
        typer.Option(help="TOML file with the table `uncertainty`; it precedes what the recording declares."),
    ] = None,
    draws: Annotated[
        float | None, typer.Option("--monte-carlo", help="Check by so many draws, as 1e5; 0: as many as needed.")
    ] = None,
    variant: VariantOption = None,
    models: ModelsOption = None,
    window: WindowOption = "d30",
    calibration: CalibrationOption = None,
    html: HtmlOption = None,
    result: TableOptions,
) -> None:
    """Uncertainty budget of a fit or of a series: what contributes, and what is not declared."""
    from platform_daemon.core.command_line.parsing import parse_window
    from platform_daemon.core.command_line.progress import compile_fit
    from platform_daemon.features.fit.fit_request import FitSettings
    from platform_daemon.features.fit.measurement import open_for_fit

    from .declared import declared_by
    from .report import budget_text, off_centre_line
    from .work import budgets_of, monte_carlo_of
    from .written import budget_report, budgets_report, one_report

    if shot is not None and series:
        raise InputError("a shot and the series exclude each other", where="--shot", remedy="give one of the two")
    result.check()
    must_not_exist(html, result.force, ".html")
    trials = _trials(draws)
    declared = None if uncertainty is None else declared_by(uncertainty)
    settings = FitSettings(
        variant_named(variant, models), parse_window(window), calibration=calibration_in(calibration)
    )
    measurement, ask = open_for_fit(file, settings)
    say_note(measurement.path, measurement.other_layout)
    compile_fit()
    found = budgets_of(measurement, ask, shot, series=series, declared=declared, coverage=coverage)
    chosen = found.budgets if quantity == _ALL else (found.of(quantity),)
    drawn = [None if draws is None else monte_carlo_of(each, trials) for each in chosen]
    change_k = found.temperature_change_k
    told = [budget_report(each, by_draws, change_k) for each, by_draws in zip(chosen, drawn, strict=True)]
    everything = budgets_report(found, str(file)).model_copy(update={"budgets": tuple(told)})
    write_json(result.json_file, everything if quantity == _ALL else one_report(found, quantity, drawn[0]))
    write_csv(
        result.csv_file, ({"quantity": each.quantity, **line.model_dump()} for each in told for line in each.inputs)
    )
    if html is not None:
        from .page import budget_page

        write_page(html, budget_page(everything))
    shots = "1 shot" if len(found.frames) == 1 else f"mean of {len(found.frames)} shots"
    at = "" if found.temperature_c is None else f" at {found.temperature_c:.2f} deg C"
    print(f"{file}: {shots}{at}")
    for each in told:
        print(budget_text(each))
    if everything.off_centre is not None:
        print(off_centre_line(everything.off_centre))
    if quantity == _ALL and everything.direction is not None:
        cone = math.degrees(everything.direction.cone_rad)
        known = f"within a cone of {cone:.2g} degrees" if everything.direction.cone_rad < math.pi else "not known"
        print(f"direction of the rotor: {known} ({coverage:.0%})")


def _trials(draws: float | None) -> int | None:
    """Raises InputError for what is no number of draws."""
    if draws is None or draws == 0:
        return None
    if not (draws >= 1 and draws.is_integer()):
        remedy = "give a whole number, as 1e5, or 0 for as many as are needed"
        raise InputError(f"{draws:g} draws", where="--monte-carlo", remedy=remedy)
    return int(draws)
