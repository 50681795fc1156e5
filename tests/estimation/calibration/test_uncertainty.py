"""The systematic uncertainty of m_r against what errors of P really do to a fit."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from platform_daemon.core.schemas.fits import unfitted
from platform_daemon.estimation.calibration.uncertainty import systematic_std
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.features.fit.fit import file_report, fit_frame, frame_report
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.report import fit_table_text
from tests.kit.ring_down_generator import RATE_HZ, Truth, dmdt, with_noise

P = np.array([[1.12e-3, 8e-6, -5e-6], [-6e-6, 1.05e-3, 9e-6], [4e-6, -7e-6, 8.8e-4]])
FREQUENCY_HZ = np.array([100.0, 215.0, 430.0, 1000.0])
NOISE = 2e-3  # of P, relative to its diagonal
DRAWS = 100
SHOTS = {
    "thread": Truth(),
    "jewel": Truth(f_nat_hz=213.0, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.9, psi_start_rad=3.86),
}
"""A small and a large swing."""


def calibration(**changes: Any) -> ReceiveCalibration:
    flat = np.ones((3, FREQUENCY_HZ.size), dtype=complex)
    std = np.full((3, 3, FREQUENCY_HZ.size), NOISE * np.abs(np.diag(P)).mean())
    made = ReceiveCalibration(P, frequency_hz=FREQUENCY_HZ, frequency_response=flat, p_std=std, relative_std=0.0)
    return replace(made, **changes)


@pytest.fixture(scope="module", params=list(SHOTS))
def shot(request: pytest.FixtureRequest) -> tuple[str, Truth, NDArray[np.float64]]:
    truth = SHOTS[request.param]
    return request.param, truth, with_noise(dmdt(truth, 0.3), np.random.default_rng(1))


def fitted(volts: NDArray[np.float64], variant: str, used: ReceiveCalibration) -> Any:
    fit = fit_frame(volts, RATE_HZ, used, FitRequest(variant, "n50"))
    assert fit.verdict == "good", fit.reason
    return fit


@pytest.mark.long
def test_moments_fitted_with_wrong_p_scatter_by_what_was_said_at_most(
    shot: tuple[str, Truth, NDArray[np.float64]],
) -> None:
    variant, truth, signal = shot
    rng = np.random.default_rng(5)
    e_u, e_v, _ = rotation_from_rodrigues(np.array(truth.rodrigues)).T
    odd, even = np.outer(e_v, e_v) @ signal, np.outer(e_u, e_u) @ signal
    rest = signal - odd - even
    used = calibration()
    assert used.p_std is not None
    right = fitted(-P @ signal, variant, used)
    moments = []
    for _ in range(DRAWS):
        at_f, at_2f = (P + used.p_std[:, :, 0] * rng.standard_normal((3, 3)) for _ in range(2))
        found = fitted(-(at_f @ odd + at_2f @ even + P @ rest), variant, used)
        moments.append(found.parameters["m_r_am2"].value)
    said = right.systematic_std["m_r_am2"]
    sure = 1 + 4 / math.sqrt(2 * DRAWS)  # of a standard deviation from so many draws
    assert 0.6 * said / sure < np.std(moments) < said * sure


def test_what_all_of_p_shares_scales_the_moment(shot: tuple[str, Truth, NDArray[np.float64]]) -> None:
    variant, _, signal = shot
    used = calibration(relative_std=0.02, p_std=None)
    right, louder = (fitted(-scale * P @ signal, variant, used) for scale in (1.0, 1.02))
    moved = louder.parameters["m_r_am2"].value - right.parameters["m_r_am2"].value
    assert right.systematic_std["m_r_am2"] == pytest.approx(moved, rel=1e-3)


def test_it_is_not_in_the_statistical_error(shot: tuple[str, Truth, NDArray[np.float64]]) -> None:
    variant, _, signal = shot
    unsure, sure = (fitted(-P @ signal, variant, calibration(relative_std=r)) for r in (0.5, 0.0))
    assert unsure.parameters == sure.parameters
    np.testing.assert_array_equal(unsure.covariance, sure.covariance)
    assert unsure.systematic_std["m_r_am2"] > 0.4 * unsure.parameters["m_r_am2"].value


def test_a_sensitivity_without_further_information_shares_its_largest_error(
    shot: tuple[str, Truth, NDArray[np.float64]],
) -> None:
    variant, _, signal = shot
    used = calibration(relative_std=None, p_std=None, sensitivity_std=np.abs(P) * np.array([[0.01], [0.03], [0.02]]))
    fit = fitted(-P @ signal, variant, used)
    assert fit.systematic_std["m_r_am2"] == pytest.approx(0.03 * fit.parameters["m_r_am2"].value)


def test_a_calibration_without_uncertainty_gives_none(shot: tuple[str, Truth, NDArray[np.float64]]) -> None:
    variant, _, signal = shot
    fit = fitted(-P @ signal, variant, calibration(relative_std=None, p_std=None))
    assert fit.systematic_std == {}
    assert systematic_std(None, fit) == {}


def test_a_moment_that_was_held_has_none(shot: tuple[str, Truth, NDArray[np.float64]]) -> None:
    variant, truth, signal = shot
    ask = FitRequest(variant, "n50", fixed={"m_r_am2": truth.m_r_am2})
    assert fit_frame(-P @ signal, RATE_HZ, calibration(relative_std=0.01), ask).systematic_std == {}


def test_reports_and_table_show_it_next_to_the_errors(shot: tuple[str, Truth, NDArray[np.float64]]) -> None:
    variant, _, signal = shot
    used, ask = calibration(relative_std=0.01), FitRequest(variant, "n50")
    fit = fitted(-P @ signal, variant, used)
    frames = [frame_report(0, fit), unfitted(1, "a blank shot"), frame_report(2, fit)]
    report = file_report("shot.h5", ask, frames, used)
    assert frames[0].systematic_std == fit.systematic_std
    assert frames[1].systematic_std == {}
    assert report.systematic_std["m_r_am2"] == pytest.approx(fit.systematic_std["m_r_am2"])
    assert "systematic standard uncertainty of" in fit_table_text(report)
    assert "systematic" not in fit_table_text(file_report("shot.h5", ask, frames[1:2], used))
