"""Shots of one recording in points, and the points of many recordings on one mirror image."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from platform_daemon.core.recordings.indexed import IndexedRecording, IndexedShot
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.features.trends.points import points_in, points_of
from platform_daemon.features.trends.trend import specimen_trend

BEGIN = datetime(2026, 1, 1, tzinfo=UTC)
TURNED = np.array([0.3, -0.9, 0.7])


def shot(minutes, vector=TURNED, f_nat=213.0, field=1.2e-3, temperature=21.0):
    values = {"f_nat_hz": f_nat, "psi_start_rad": 1.0, **dict(zip(RODRIGUES, map(float, vector), strict=True))}
    return IndexedShot(0, (BEGIN + timedelta(minutes=minutes)).isoformat(), temperature, field, values)


def recording(k, shots):
    return IndexedRecording(f"r{k}", BEGIN.isoformat(), "T", "", 1, 1, "c", "d30 jewel", points=points_in(shots))


def test_shots_within_ten_minutes_at_one_field_are_one_point():
    shots = [shot(m, f_nat=f, temperature=t) for m, f, t in ((0, 213, 20), (9, 215, None), (11, 300, 25))]
    found = points_in([*shots, shot(12, field=2e-3, temperature=None)])
    assert [p.shots for p in found] == [2, 1, 1]
    assert [p.values["f_nat_hz"] for p in found] == [214.0, 300.0, 213.0]
    assert [p.temperature_c for p in found] == [20.0, 25.0, None]
    assert points_in([]) == ()


@pytest.mark.parametrize("seed", range(5))
def test_orientations_of_many_recordings_are_of_one_mirror_image_whichever_each_shot_was_given_as(seed):
    rng = np.random.default_rng(seed)
    half_turn = Rotation.from_rotvec([np.pi, 0.0, 0.0])

    def given():
        turned = Rotation.from_rotvec(TURNED + rng.normal(0.0, 1e-3, 3))
        return (turned * half_turn if rng.random() < 0.5 else turned).as_rotvec()

    recordings = [recording(k, [shot(100 * k + m, given()) for m in range(8)]) for k in range(12)]
    found = Rotation.from_rotvec([[p.values[name] for name in RODRIGUES] for p in points_of(recordings)])
    either = min(
        (found * reference.inv()).magnitude().max()
        for reference in (Rotation.from_rotvec(TURNED), Rotation.from_rotvec(TURNED) * half_turn)
    )
    assert either < 3e-3


def test_a_quick_look_in_another_window_now_and_then_makes_nothing_begin_anew():
    rng = np.random.default_rng(1)

    def one(k):
        quick = k % 7 == 3  # half a hertz off, as the model says less there
        f_nat = 213.0 * (1.0 + rng.normal(0.0, 1e-5) - (1e-4 if k >= 200 else 0.0)) + (0.5 if quick else 0.0)
        made = recording(k, [shot(0, f_nat=f_nat, temperature=21.0 + rng.normal(0.0, 0.1))])
        later = replace(made.points[0], at=(BEGIN + timedelta(hours=k)).isoformat())
        return replace(made, fit="n50 jewel" if quick else "d30 jewel", points=(later,))

    recordings = [one(k) for k in range(260)]
    report = specimen_trend("T", recordings)
    (change,) = [each for each in report.changes if "f_nat_hz" in each.quantities]
    assert (change.name, change.since_recording, change.stands) == ("drift", "r200", True)
    assert change.relative == pytest.approx(-1e-4, rel=0.2)
    (chart,) = [each for each in report.charts if each.quantity == "f_nat_hz"]
    assert len(chart.value) == len(chart.corrected) == len(chart.score) == 260
    assert max(abs(a - b) for a, b in zip(chart.value, chart.corrected, strict=True)) < 0.05
    assert any("2 kinds of fits" in note for note in report.notes)
    tail = specimen_trend("T", recordings, newest=30)
    assert tail.notes[0] == "the newest 30 of 260 points are listed"
    assert (tail.points, tail.changes) == (report.points[-30:], report.changes)
    (listed,) = [each for each in tail.charts if each.quantity == "f_nat_hz"]
    assert (listed.value, listed.ewma, listed.limit) == (chart.value[-30:], chart.ewma[-30:], chart.limit[-30:])
    assert listed.relative_per_k == chart.relative_per_k


def test_what_is_below_zero_now_and_then_is_told_relative_to_its_value_too():
    rng = np.random.default_rng(2)

    def one(k):
        warm = 22.0 + 4.0 * np.sin(k / 20.0)
        made = recording(k, [shot(0, temperature=warm)])
        damping = 0.1 * (1.0 + 0.05 * (warm - 22.0) + (1.0 if k >= 200 else 0.0)) + 0.05 * rng.normal()
        later = (BEGIN + timedelta(hours=k)).isoformat()
        point = replace(made.points[0], at=later, values={"lambda_per_s": damping})
        return replace(made, points=(point,))

    report = specimen_trend("T", [one(k) for k in range(300)])
    (chart,) = report.charts
    assert min(chart.value) < 0.0
    assert abs(chart.relative_per_k - 0.05) < 4.0 * chart.relative_per_k_std < 0.1
    assert report.changes[0].relative == pytest.approx(1.0, abs=0.4)
