"""The benchmark runs, and says what it says it says."""

from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.estimation.compilation import synthetic_record
from platform_daemon.estimation.fit import fit_ring_down
from tests.benchmarks import solvers
from tests.benchmarks.campaign import campaign_text, run_campaign
from tests.benchmarks.fits import DATASETS, RATE_HZ, demodulate, make_record, run_bench, table
from tests.benchmarks.process import _FIRST_FIT, linearity, peak_memory, processes_text


def test_a_short_benchmark_gives_times_ratios_and_a_table():
    report = run_bench(repeats=2, paper_seconds=0.3, datasets=DATASETS[:1])
    row = report["datasets"]["JN50"]
    assert row["verdict"] == "good"
    assert row["samples"] == 14648
    assert row["fit_ms"] > 0.0
    assert row["fit_over_demodulation"] == row["fit_ms"] / row["demodulation_ms"]
    assert row["paper_finished"] is False
    assert 0.3 <= row["paper_s"] < 3.0
    assert "JN50" in table(report)


def test_the_paper_s_method_can_be_left_out():
    row = run_bench(repeats=1, paper_seconds=0.0, datasets=DATASETS[2:3])["datasets"]["TN50"]
    assert row["paper_s"] is row["paper_finished"] is row["paper_over_fit"] is None


def test_what_a_first_process_runs_fits(capsys):
    exec(_FIRST_FIT, {})
    assert '"verdict": "good"' in capsys.readouterr().out


def test_records_are_the_same_every_time():
    assert (make_record(DATASETS[2]).samples == make_record(DATASETS[2]).samples).all()


def test_the_floor_demodulates_what_it_is_given():
    t = np.arange(2560) / RATE_HZ
    f = 10 * RATE_HZ / 2560
    found = demodulate(np.stack([2.0 * np.cos(2 * np.pi * f * t), np.sin(6 * np.pi * f * t)]), f)
    expected = np.zeros((5, 2), dtype=complex)
    expected[0, 0], expected[2, 1] = 2.0, -1j
    assert np.allclose(found, expected, atol=1e-9)


@pytest.mark.long
def test_the_campaign_fits_every_shot_of_every_dataset_in_two_processes():
    report = run_campaign(shots=3, processes=2)
    assert report["fits"] == report["good"] == 12
    assert report["wall_s"] > 0
    assert report["processor_s"] > 0
    assert "12 fits, 2 processes" in campaign_text(report)


def test_memory_and_growth_are_measured_against_the_record():
    short = replace(DATASETS[2], seconds=0.1)
    memory = peak_memory(short)
    assert memory["record_bytes"] == make_record(short).samples.nbytes
    assert memory["peak_over_record"] == memory["peak_bytes"] / memory["record_bytes"] > 0.0
    growth = linearity(short, repeats=1)
    assert abs(growth["samples"][2] - 4 * growth["samples"][0]) <= 2  # rounded to whole samples
    assert abs(growth["relative"][0] - 1.0) < 1e-12


def test_the_first_fits_of_fresh_processes_are_reported():
    fit = {"verdict": "good", "wall_s": 1.5, "processor_s": 1.25}
    first = {"cold": {**fit, "wall_s": 12.5}, "warm": fit, "must_cold_s": 20.0, "must_warm_s": 2.0}
    memory = {"record_bytes": 7_000_000, "peak_bytes": 3_500_000, "peak_over_record": 0.5, "must": 3.0}
    growth = {"samples": [10, 20, 40], "fit_ms": [1.0, 2.0, 4.4], "relative": [1.0, 1.0, 1.1]}
    text = processes_text({"first_fit": first, "memory": memory, "linearity": growth})
    assert "12.5 s (must 20 s; processor time 1.2 s)" in text
    assert "0.50 of the record's 7.0 MB" in text
    assert "4.4 ms (1.10)" in text


def test_the_record_of_the_first_fit_can_be_fitted():
    record, noise = synthetic_record()
    assert fit_ring_down(record, "thread", noise=noise).verdict == "good"


def test_solvers_of_others_are_left_out_where_they_are_not_installed(monkeypatch):
    monkeypatch.setattr(solvers, "find_spec", lambda name: None)
    assert "not installed" in solvers.solvers_text(solvers.run_solvers(), 1.0)


def test_solvers_begin_near_the_truth_and_newton_s_steps_lead_there():
    scale, start = solvers.near_truth()
    assert np.abs(start - 1.0).max() < 0.011
    assert scale[2] == DATASETS[2].dynamics.w
    slope = np.diag([1.0, 2.0, 3.0])
    found, steps = solvers.gauss_newton(lambda x: (slope @ (x - 1.0), slope), np.zeros(3))
    assert np.allclose(found, 1.0)
    assert steps == 2
    told = {"diffrax": {"fit_ms": 100.0, "steps": 5, "compile_s": 4.0}}
    assert "50 times our fit" in solvers.solvers_text(told, 2.0)
