"""On-line fits of a series that were corrected for an adopted manufacturing error, beside the fit of five degrees of
freedom and the simulated truth; and how long one of them takes.

python -m tests.benchmarks.corrected_fit SERIES.h5 NAME@1 --models data/models

The series is one of the simulated platform, measured with `--variant NAME@1`.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from statistics import median

import numpy as np

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recorded_fits import read_fit
from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.features.fit.corrected import corrections_of
from platform_daemon.features.fit.fit import fit_frame_of
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.measurement import VoltageMeasurement
from platform_daemon.features.models.library import Library
from platform_daemon.library.simulate import simulate

NAMES = ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2")
REPEATS = 100
COUNT = 20_000_000


def main() -> None:
    """Print a table of errors over standard deviations, and the median time of a fit."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("series", type=Path)
    asked.add_argument("model")
    asked.add_argument("--models", type=Path, default=Path("data/models"))
    given = asked.parse_args()
    measurement = VoltageMeasurement.of(open_recording(given.series))
    ask = FitRequest(Library(given.models).get(given.model), weight_over_pull=measurement.weight_over_pull())
    table, truth = read_fit(measurement.recording, "d30"), read_truth(given.series)
    for k in range(measurement.frames):
        true = truth[k]["simulated"]
        full = fit_frame_of(measurement, k, ask)
        print(f"shot {k + 1}: {table.reason[k] or 'corrected'}; chi2/dof {table.chi2_per_dof[k]:.4f}")
        for name in NAMES:
            if name in table.parameters and name in full.parameters:
                place = table.parameters.index(name)
                value, std, other = table.values[k, place], table.std[k, place], full.parameters[name]
                print(
                    f"  {name:22s} corrected {value:.8g} ({std:.2g}), full {other.value:.8g} ({other.std or 0:.2g}), "
                    f"true {true[name]:.8g}: {(value - true[name]) / std:+.2f}, "
                    f"{(other.value - true[name]) / (other.std or np.nan):+.2f} std; full {full.seconds:.2g} s"
                )
    _time(measurement, ask, given.models)


def _time(measurement: VoltageMeasurement, ask: FitRequest, models: Path) -> None:
    record = measurement.signal(0).record
    noise = measurement.noise().for_shot(record).model
    corrections = corrections_of(measurement.recording, ask, record.valid_from, models)
    window_s = corrections.fit(record, "d30", noise)[0].window_s or 1.0
    variant = corrections.basis.geometry.bearing
    simulated = simulate(variant, phi_max_deg=25, seconds=window_s + 0.1)
    plain = simulated.measurement.signal(0).record
    for name, fit in {
        "corrected": lambda: corrections.fit(record, "d30", noise),
        "ordinary, as many samples of one angle": lambda: fit_ring_down(plain, variant, window_s, noise=noise),
    }.items():
        spent, processor = [], []
        for _ in range(REPEATS):
            began, used = time.perf_counter(), time.thread_time()
            fit()
            spent.append(time.perf_counter() - began)
            processor.append(time.thread_time() - used)
        print(
            f"{name}: median of {REPEATS}: {1e3 * median(spent):.1f} ms, of the processor "
            f"{1e3 * median(processor):.1f} ms, least {1e3 * min(processor):.1f} ms"
        )
    began, total = time.thread_time(), 0
    for k in range(COUNT):
        total += k
    print(f"a loop of {COUNT:.0e} additions takes {time.thread_time() - began:.2f} s here")


if __name__ == "__main__":
    main()
