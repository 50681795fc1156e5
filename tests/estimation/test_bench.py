"""The benchmark runs, and says what it says it says."""

import numpy as np

from platform_daemon.estimation.bench import DATASETS, RATE_HZ, demodulate, make_record, run_bench, table
from platform_daemon.estimation.bench_campaign import campaign_text, run_campaign


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


def test_records_are_the_same_every_time():
    assert (make_record(DATASETS[2]).samples == make_record(DATASETS[2]).samples).all()


def test_the_floor_demodulates_what_it_is_given():
    t = np.arange(2560) / RATE_HZ
    f = 10 * RATE_HZ / 2560
    found = demodulate(np.stack([2.0 * np.cos(2 * np.pi * f * t), np.sin(6 * np.pi * f * t)]), f)
    expected = np.zeros((5, 2), dtype=complex)
    expected[0, 0], expected[2, 1] = 2.0, -1j
    assert np.allclose(found, expected, atol=1e-9)


def test_the_campaign_fits_every_shot_of_every_dataset_in_two_processes():
    report = run_campaign(shots=3, processes=2)
    assert report["fits"] == report["good"] == 12
    assert report["wall_s"] > 0
    assert report["processor_s"] > 0
    assert "12 fits, 2 processes" in campaign_text(report)
