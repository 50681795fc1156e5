"""What budgets cost: python -m tests.benchmarks.budget_cost [--shots N] [--repeats N]

In one process, in computing time, so that what else the computer does counts little: the share of the budgets in
`characterise`, the share of covariance and reading in an on-line fit, and the time of a budget of a whole series.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Annotated, Any
from unittest.mock import patch

import typer

from platform_daemon.estimation.compilation import warm_up
from platform_daemon.features.budget.work import series_budgets
from platform_daemon.features.characterise import tables
from platform_daemon.features.fit.batch.executors import in_this_process
from platform_daemon.features.fit.fit import fit_frame_of, frame_report
from platform_daemon.features.fit.fit_request import FitSettings
from platform_daemon.features.fit.measurement import open_for_fit
from platform_daemon.features.measurand.online import reading_of
from platform_daemon.features.measurand.work import calibrated
from tests.kit.pressure_sensor import PRESSURE, START_S, PressureSensor

_ALPHA = 0.001


class Spent:
    """Computing time of all calls of a function, s."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.seconds, self._function = 0.0, function

    def __call__(self, *arguments: Any, **keys: Any) -> Any:
        """As the function."""
        began = time.process_time()
        try:
            return self._function(*arguments, **keys)
        finally:
            self.seconds += time.process_time() - began


def characterise_share(file: Path) -> float:
    """Computing time of the budgets over that of all the rest of one `characterise`."""
    spent, whole = Spent(tables.budgets_of_means), Spent(tables.characterise)
    with patch.object(tables, "budgets_of_means", spent), in_this_process() as workers:
        report = whole(tables.characterisation_task(file, FitSettings(), None, _ALPHA), workers, lambda *_: None)
    assert report.mean_budgets
    return spent.seconds / (whole.seconds - spent.seconds)


def online_share(file: Path, repeats: int) -> tuple[float, float]:
    """Computing time of a fit's report with covariance, and of a reading, over that of the fit."""
    measurement, ask = open_for_fit(file, FitSettings())
    sensor = PressureSensor(1)
    made = calibrated(
        "sensor", PRESSURE, sensor.shots(START_S, 200, 900.0)[0], sensor.reference(START_S, START_S + 180e3), 1
    )
    fit, report, reading = Spent(fit_frame_of), Spent(frame_report), Spent(reading_of)
    for k in range(repeats):
        found = fit(measurement, k % measurement.frames, ask)
        report(k, found)
        reading(made, sensor.f_hz(1000.0, 22.0), 22.0, START_S)
    return report.seconds / fit.seconds, reading.seconds / fit.seconds


def series_seconds(file: Path) -> float:
    """Computing time of the budgets of the mean of a series by its recorded fits, opening it included, s."""
    began = time.process_time()
    series_budgets(*open_for_fit(file, FitSettings()))
    return time.process_time() - began


def main(
    shots: Annotated[int, typer.Option(min=2, help="Of the jewel, simulated.")] = 100,
    repeats: Annotated[int, typer.Option(min=1, help="Of each figure, of which the median is told.")] = 3,
) -> None:
    """Measure a series, and print what its budgets cost."""
    from tests.kit.command_line import here

    warm_up()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "jewel.h5")
        done = here("measure", "--resonator", "jewel", "--shots", shots, "--out", file)
        assert done.returncode == 0, done.stderr
        online_share(file, 2), series_seconds(file)  # what is made once in a process
        share = median(characterise_share(file) for _ in range(repeats))
        print(f"characterise of {shots} shots: budgets add {share:.1%}")
        report, reading = online_share(file, 10 * repeats)
        print(f"an on-line fit: its report with covariance adds {report:.1%}, a reading as a sensor {reading:.1%}")
        print(f"a budget of the series: {median(series_seconds(file) for _ in range(repeats)):.2f} s of computing time")


if __name__ == "__main__":
    typer.run(main)
