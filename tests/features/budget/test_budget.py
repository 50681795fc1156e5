"""Budgets of fits: sensitivities against fits that are made again, what is declared, what is refused, and coverage."""

import json
import math
import os
from dataclasses import replace

import numpy as np
import pytest

import platform_daemon as pd_
from drivers.uncertainty import DeclaredUncertainty
from platform_daemon.features.budget.influences import pair_fields
from platform_daemon.features.budget.off_centre import least_distance
from platform_daemon.features.budget.response import response_of, turned_to_rodrigues
from platform_daemon.features.budget.statistics import independent
from platform_daemon.features.budget.work import monte_carlo_of, parts_of_fits, series_budgets, shot_budgets
from platform_daemon.features.fit.fit import fit_frame_of, fit_measurement
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.measurement import open_measurement
from platform_daemon.features.fit.series_table import recorded_fits
from tests.kit.command_line import assert_one_line_error, here

RATE_HZ = 61035.15625
DECLARED = {
    "sample_clock": {"u": 1e-5},
    "reference_dipole": {"u": 1e-2, "source": "certificate"},
    "gain": {"u": 1e-3},
}


def _simulated(seed=1, rate_hz=RATE_HZ, **more):
    values = {"phi_max_deg": 40.0, "seconds": 0.8, "seed": seed, "sampling_rate_hz": rate_hz, **more}
    return pd_.simulate("jewel", **values)


@pytest.fixture(scope="module")
def recording():
    return _simulated()


@pytest.fixture(scope="module")
def fit(recording):
    return pd_.fit(recording, window=0.6)


def _again(recording, samples, rate_hz=RATE_HZ):
    time_s = np.arange(samples.shape[1]) / rate_hz
    return pd_.fit(pd_.from_arrays(time_s, samples, variant="jewel"), window=0.6 * RATE_HZ / rate_hz)


def _budgets(recording, fit, declared, **more):
    said = DeclaredUncertainty.model_validate(declared)
    return shot_budgets(recording.measurement, 0, FitRequest("jewel", 0.6), fit=fit.result, declared=said, **more)


def _sensitivity(budget, name):
    return next((line.sensitivity for line in budget.contributions if line.input.name == name), 0.0)


@pytest.mark.parametrize("mixing", ["gain of channel x", "gain of channel y", "orthogonality of coil x and y"])
def test_response_is_that_of_a_fit_made_again(recording, fit, mixing):
    size, matrix = 1e-4, np.zeros((3, 3))
    matrix[{"gain of channel x": (0, 0), "gain of channel y": (1, 1)}.get(mixing, (0, 1))] = 1.0
    samples = recording.signal(0)
    response = response_of(fit.result, recording.measurement.signal(0).record)
    told = dict(zip(response.names, response.of_mixing(matrix, response.odd + response.even), strict=True))
    mixed = size * matrix @ fit.model_signal()  # of the data, the noise would be mixed too
    ends = [_again(recording, samples + sign * mixed) for sign in (1.0, -1.0)]
    for name in ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2", "rodrigues_z"):
        found = (ends[0][name].value - ends[1][name].value) / (2.0 * size)
        # lambda follows the ends of the window, which the response knows to a fraction of a period.
        share = 0.02 if name == "lambda_per_s" else 0.005
        assert told[name] == pytest.approx(found, rel=share, abs=1e-6 * abs(fit[name].value))


def test_the_chances_that_thresholds_name():
    """White series are rarely taken for correlated ones, and correlated ones always."""
    random = np.random.default_rng(0)

    def share(n, r, draws=1000):
        series = random.standard_normal((draws, n))
        for k in range(1, n):
            series[:, k] += r * series[:, k - 1]
        return np.mean([independent(row - row.mean()) < n for row in series])

    assert share(20, 0.0) < 0.02
    assert 0.005 < share(100, 0.0) < 0.035
    assert share(100, 0.6) > 0.99


def test_all_of_p_scales_the_moment_alone(recording, fit):
    response = response_of(fit.result, recording.measurement.signal(0).record)
    told = dict(zip(response.names, response.of(response.odd + response.even), strict=True))
    assert told["m_r_am2"] == pytest.approx(fit["m_r_am2"].value, rel=1e-3)
    assert told["f_nat_hz"] == pytest.approx(0.0, abs=1e-3)


def test_a_clock_that_is_fast(recording, fit):
    found = _again(recording, recording.signal(0), RATE_HZ * (1.0 + 1e-4))
    budgets = _budgets(recording, fit, DECLARED)
    for name in ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2"):
        change = (found[name].value - fit[name].value) / 1e-4
        assert _sensitivity(budgets.of(name), "sample clock") == pytest.approx(change, rel=2e-3)


def test_contributions_add_up(recording, fit):
    budgets = _budgets(recording, fit, DECLARED)
    moment = budgets.of("m_r_am2")
    assert moment.by_contribution()[0].input.name == "calibration"
    assert moment.u == pytest.approx(math.sqrt(sum(line.contribution**2 for line in moment.contributions)))
    assert moment.u == pytest.approx(1e-2 * fit["m_r_am2"].value, rel=0.02)
    names = [each.quantity for each in budgets.budgets]
    k = names.index("m_r_am2")
    assert math.sqrt(budgets.covariance[k, k]) == pytest.approx(moment.u, rel=1e-3)
    noise = next(line for line in moment.contributions if line.input.name == "noise")
    assert noise.contribution == pytest.approx(fit["m_r_am2"].std)


def test_what_is_not_declared_is_listed_with_its_size(recording, fit):
    found = _budgets(recording, fit, {}).of("f_nat_hz")
    told = {each.name: each.would_add_per_unit for each in found.not_declared}
    assert told["sample clock, per 1e-6 of its frequency"] == pytest.approx(1e-6 * found.value)
    assert told["temperature, per 1 K"] == pytest.approx(1.1e-3 * found.value)
    assert [line.input.name for line in found.contributions] == ["noise"]


def test_declared_correlations_count(recording, fit):
    pair = {"between": ["gain of channel x", "gain of channel y"], "r": 1.0}
    alone = _budgets(recording, fit, DECLARED).of("f_nat_hz")
    both = _budgets(recording, fit, {**DECLARED, "correlation": [pair]}).of("f_nat_hz")
    parts = [_sensitivity(both, f"gain of channel {axis}") * 1e-3 for axis in "xy"]
    assert both.u**2 - alone.u**2 == pytest.approx(2.0 * parts[0] * parts[1], rel=1e-6)


def test_monte_carlo_agrees(recording, fit):
    budget = _budgets(recording, fit, DECLARED).of("m_r_am2")
    drawn = monte_carlo_of(budget, 50_000)
    assert pd_.check_law_of_propagation(budget, drawn).holds


def test_an_expired_certificate_is_refused(recording, fit):
    paper = {"number": "PTB 12", "date": "2020-01-01", "valid_until": "2021-01-01"}
    with pytest.raises(pd_.InputError, match=r"sample_clock: certificate PTB 12: expired on 2021-01-01"):
        _budgets(recording, fit, {"sample_clock": {"u": 1e-6, "certificate": paper}})


def test_correlations_that_contradict_each_other_are_refused(recording, fit):
    pairs = [("x", "y", 0.9), ("y", "z", 0.9), ("x", "z", -0.9)]
    said = [{"between": [f"gain of channel {a}", f"gain of channel {b}"], "r": r} for a, b, r in pairs]
    with pytest.raises(pd_.InputError, match="contradict each other"):
        _budgets(recording, fit, {**DECLARED, "correlation": said})


def test_a_quantity_that_the_fit_does_not_have(fit):
    with pytest.raises(pd_.InputError, match="one of: f_nat_hz, m_r_am2"):
        fit.budget("temperature")


def test_field_off_the_centre_is_that_of_helmholtz_pairs():
    r = (0.1, 0.1, 0.1)
    assert 1.0 - pair_fields(np.array([0.0, 0.0, 0.01]), r)[2, 2] == pytest.approx(1.152e-4, rel=1e-3)
    assert 1.0 - pair_fields(np.array([0.02, 0.0, 0.0]), r)[2, 2] == pytest.approx(0.375 * 1.152 * 0.2**4, rel=1e-9)
    # Free of sources: the divergence of each pair's field vanishes.
    place, h = np.array([0.012, -0.007, 0.009]), 1e-5
    for coil in range(3):
        slopes = [
            (pair_fields(place + h * e, r) - pair_fields(place - h * e, r))[coil, k] for k, e in enumerate(np.eye(3))
        ]
        assert sum(slopes) / max(map(abs, slopes)) == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize(("axis", "ratio"), [(0, 1.0), (1, 0.76), (2, 0.67)])
def test_a_place_along_y_or_z_looks_like_a_nearer_one(axis, ratio):
    """A ring-down about z shows two numbers of the mixing: how the odd harmonics, along x, are scaled against the even
    ones, along y, and the angle between both.  The pairs' field makes the same two at a nearer place."""
    radii = (0.050, 0.057, 0.065)

    def shown(place):
        mixing = pair_fields(place, radii) - np.eye(3)
        return np.array([mixing[0, 0] - mixing[1, 1], mixing[0, 1] + mixing[1, 0]])

    seen = shown(0.02 * np.eye(3)[axis])
    told = np.zeros((9, 2))  # the same two numbers of the nine of a mixing
    told[[0, 4], 0], told[[1, 3], 1] = (1.0, -1.0), 1.0
    spread = np.eye(2) * (1e-4 * np.linalg.norm(seen)) ** 2
    least = least_distance(seen, spread, told, radii)
    assert 0.95 * ratio * 0.02 < least < ratio * 0.02


@pytest.mark.parametrize(
    ("place_mm", "seen"), [((0, 0, 0), False), ((12, 0, 0), True), ((0, 12, 0), True), ((15, 10, 0), True)]
)
def test_a_rotor_off_the_centre_is_named_with_its_distance(place_mm, seen):
    radii, place = (0.050, 0.057, 0.065), 1e-3 * np.array(place_mm, float)
    made = _simulated(seed=3)
    samples = pair_fields(place, radii) @ made.signal(0)
    again = pd_.from_arrays(np.arange(samples.shape[1]) / RATE_HZ, samples, variant="jewel")
    said = DeclaredUncertainty(coil_radius_m=radii)
    told = shot_budgets(again.measurement, 0, FitRequest("jewel", 0.6), declared=said).off_centre
    assert told.seen == seen
    if seen:
        assert 0.6 * np.linalg.norm(place) < told.distance_m <= 1.003 * np.linalg.norm(place)
    # What is declared of the coils' angles explains as much as 12 mm: then nobody can tell.
    loose = DeclaredUncertainty(coil_radius_m=radii, orthogonality_rad={"u": 5e-3}, gain={"u": 5e-3})
    assert not shot_budgets(again.measurement, 0, FitRequest("jewel", 0.6), declared=loose).off_centre.seen


@pytest.mark.parametrize("vector", [(0.0, 0.0, -1.57), (0.3, -0.2, 3.1), (0.01, 0.0, 0.0)])
def test_small_rotations_of_a_rodrigues_vector(vector):
    from scipy.spatial.transform import Rotation

    turned = turned_to_rodrigues(np.array(vector))
    small = np.array([2e-4, -1e-4, 3e-4])
    found = (Rotation.from_rotvec(small) * Rotation.from_rotvec(vector)).as_rotvec()
    assert np.array(vector) + turned @ small == pytest.approx(found, abs=2e-7)


def test_command(measured, tmp_path):
    file, told, own = measured / "j.h5", tmp_path / "one.json", tmp_path / "own.toml"
    options = ("--json", told, "--csv", tmp_path / "one.csv", "--html", tmp_path / "one.html")
    done = here("budget", file, "--shot", 0, "--quantity", "f_nat_hz", "--monte-carlo", "2e4", *options)
    assert done.returncode == 0, done.stderr
    report = json.loads(told.read_text())
    line = next(each for each in report["inputs"] if each["name"] == "temperature")
    assert line["contribution"] == pytest.approx(0.023)
    assert report["U"] == pytest.approx(report["k"] * report["u"])
    assert report["monte_carlo"]["trials"] == 20_000
    assert "static field" in str(report["not_declared"])
    assert (tmp_path / "one.csv").read_text().startswith("quantity,name,value,u,type")
    assert b"data:image/png" in (tmp_path / "one.html").read_bytes()
    own.write_text("[uncertainty]\nthermometer_k = { u = -1.0 }\n")
    refused = here("budget", file, "--uncertainty", own)
    assert_one_line_error(refused, 2)
    assert "thermometer_k.u" in refused.stderr


def test_recorded_fits_are_those_that_would_be_made(measured):
    opened = open_measurement(measured / "j.h5")
    kept, made = recorded_fits(opened, FitRequest("jewel", "d30")), fit_measurement(opened, FitRequest("jewel", "d30"))
    assert [fit.frame for fit in kept] == [0, 1]
    for one, other in zip(kept, made.frames, strict=True):
        for name, estimate in other.parameters.items():
            assert one.values[name] == pytest.approx(estimate.value, abs=0.05 * estimate.std)
        assert np.array(one.covariance.matrix) == pytest.approx(np.array(other.covariance.matrix), rel=0.3)
    # On-line fits are another question's answer as soon as anything of it differs.
    assert recorded_fits(opened, FitRequest("jewel", "n50")) is None
    assert recorded_fits(opened, FitRequest("thread", "d30")) is None
    assert recorded_fits(opened, FitRequest("jewel", "d30", fixed={"f_nat_hz": 213.0})) is None
    other_calibration = replace(opened, calibration_file="other.toml")
    assert recorded_fits(other_calibration, FitRequest("jewel", "d30")) is None


def test_all_budgets_or_the_one_that_is_asked_for(measured, tmp_path):
    one, every = tmp_path / "one.json", tmp_path / "every.json"
    assert here("budget", measured / "j.h5", "--json", one).returncode == 0
    assert here("budget", measured / "j.h5", "--quantity", "all", "--json", every).returncode == 0
    asked, all_of_them = json.loads(one.read_text()), json.loads(every.read_text())
    keys = ["quantity", "value", "u", "dof", "k", "U", "coverage", "inputs", "correlations", "not_declared"]
    assert list(asked)[: len(keys)] == keys
    assert asked["quantity"] == "f_nat_hz"
    assert asked["covariance"] == all_of_them["covariance"]
    assert "m_r_am2" in [each["quantity"] for each in all_of_them["budgets"]]


def test_a_series_shares_what_its_shots_share(measured):
    opened = open_measurement(measured / "j.h5")
    found = series_budgets(opened, FitRequest("jewel", "n50"))
    moment = found.of("m_r_am2")
    lines = {line.input.name: line for line in moment.contributions}
    assert lines["calibration"].contribution == pytest.approx(1e-2 * moment.value, rel=1e-3)  # no mean makes it less
    assert lines["scatter"].input.dof == 1.0
    assert found.frames == (0, 1)


def test_fits_that_were_made_already_have_the_same_budgets(measured):
    opened, ask = open_measurement(measured / "j.h5"), FitRequest("jewel", "d30")
    long, short = (fit_measurement(opened, replace(ask, window=window)).frames for window in ("d30", "n50"))
    made = parts_of_fits(opened, ask, long, short, {})
    for found, other in zip(made.budgets(0.95).budgets, series_budgets(opened, ask).budgets, strict=True):
        assert found.value == pytest.approx(other.value, abs=0.01 * other.u)
        assert found.u == pytest.approx(other.u, rel=0.02)
    scatter = {n: made.budgets(0.95, n).of("f_nat_hz").contributions[0].contribution for n in (2, 8)}
    assert scatter[2] == pytest.approx(2.0 * scatter[8])


@pytest.mark.long
def test_coverage():
    """Every influence is drawn from what is declared of it: 95 % intervals cover the truth in about as many cases."""
    draws, random = int(os.environ.get("COVERAGE_DRAWS", "100")), np.random.default_rng(42)
    said = DeclaredUncertainty.model_validate({**DECLARED, "sample_clock": {"u": 1e-5}})
    silent = said.model_copy(update={"sample_clock": None})
    covered = dict.fromkeys(("f_nat_hz", "m_r_am2", "lambda_per_s", "silent"), 0)
    for k in range(draws):
        clock, scale = 1.0 + 1e-5 * random.standard_normal(), 1.0 + 1e-2 * random.standard_normal()
        gains = 1.0 + 1e-3 * random.standard_normal(3)
        made = _simulated(seed=k, rate_hz=RATE_HZ * clock)
        samples = scale * gains[:, None] * made.signal(0)
        again = pd_.from_arrays(np.arange(samples.shape[1]) / RATE_HZ, samples, variant="jewel")
        ask = FitRequest("jewel", "d30")
        fitted = fit_frame_of(again.measurement, 0, ask)
        found = shot_budgets(again.measurement, 0, ask, fit=fitted, declared=said)
        for name in ("f_nat_hz", "m_r_am2", "lambda_per_s"):
            low, high = found.of(name).interval
            covered[name] += low <= made.truth[name] <= high
        low, high = shot_budgets(again.measurement, 0, ask, fit=fitted, declared=silent).of("f_nat_hz").interval
        covered["silent"] += low <= made.truth["f_nat_hz"] <= high
    print(covered)
    for name in ("f_nat_hz", "m_r_am2", "lambda_per_s"):
        assert abs(covered[name] / draws - 0.95) <= 3.0 * math.sqrt(0.95 * 0.05 / draws), covered
    assert covered["silent"] / draws < 0.9, covered
