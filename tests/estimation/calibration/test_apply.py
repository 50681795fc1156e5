"""From volts to dm/dt: the inverse of P, and the receive chain undone."""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from platform_daemon.estimation.calibration.apply import calibrate
from platform_daemon.estimation.calibration.equaliser import design_equaliser
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.sensitivity import CalibrationError
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ, Truth, dmdt, errors, joint_chi2, with_noise

P = np.array([[1.12e-3, 8e-6, -5e-6], [-6e-6, 1.05e-3, 9e-6], [4e-6, -7e-6, 8.8e-4]])
POLE_HZ = 20e3
DELAY_S = 0.25 / RATE_HZ
JEWEL = Truth(f_nat_hz=213.0, m_r_am2=0.01226, tf_over_i_rad_per_s2=1190.0, phi_max_rad=0.9, psi_start_rad=3.86)
GRIDS = {
    "even": np.linspace(20.0, 30000.0, 300),
    "logarithmic": np.geomspace(10.0, 30500.0, 60),
    "ends at 10 kHz": np.linspace(0.0, 10000.0, 101),
}


def chain(f):
    return np.exp(-2j * np.pi * f * DELAY_S) / (1 + 1j * f / POLE_HZ)


def through_chain(truth, seconds):
    """(volts after a one-pole low-pass and a quarter sample of delay, dm/dt before), both from t = t0 > 0 on.

    The low-pass is integrated with the motion; the delay is one step of a grid four times finer. Both have been
    running for 3 ms (375 time constants) when the record begins.
    """
    lead = 200
    n = round(seconds * RATE_HZ)
    fine = dmdt(truth, seconds + 0.01, 4 * RATE_HZ, pole_s=1 / (2 * math.pi * POLE_HZ), substeps=2)
    clean = dmdt(truth, seconds + 0.01, 4 * RATE_HZ, substeps=2)
    return -P @ fine[:, 4 * lead - 1 :: 4][:, :n], clean[:, 4 * lead :: 4][:, :n]


def fit_of(calibrated, window):
    record = RingDownRecord(calibrated.dmdt, RATE_HZ, "dmdt", calibrated.valid_from, calibrated.valid_to)
    return fit_ring_down(record, "jewel", window, noise=NoiseModel.white(NOISE_SD, RATE_HZ))


@pytest.mark.parametrize("window", ["n50", "d30"])
@pytest.mark.parametrize("grid", sorted(GRIDS))
def test_a_receive_low_pass_biases_the_fit_and_its_response_removes_the_bias(window, grid):
    volts, clean = through_chain(JEWEL, 1.1)
    truth = fit_ring_down(
        RingDownRecord(clean, RATE_HZ, "dmdt"), "jewel", window, noise=NoiseModel.white(NOISE_SD, RATE_HZ)
    )

    def biases(result):
        return {
            n: (result.parameters[n].value - truth.parameters[n].value) / result.parameters[n].std
            for n in result.covariance_names
        }

    ignored = biases(fit_of(calibrate(volts, RATE_HZ, P), window))
    f = GRIDS[grid]
    corrected = biases(fit_of(calibrate(volts, RATE_HZ, P, f, np.repeat(chain(f)[None], 3, axis=0)), window))
    print(window, grid, "ignored", ignored, "corrected", corrected)
    assert abs(ignored["psi_start_rad"]) > 20.0
    if window == "d30":
        assert abs(ignored["m_r_am2"]) > 1.0
    assert max(abs(b) for b in corrected.values()) < 0.2


def test_a_corrected_noisy_shot_is_still_judged_rightly():
    volts, clean = through_chain(JEWEL, 1.1)
    volts = volts - P @ with_noise(np.zeros_like(clean), np.random.default_rng(1))
    f = GRIDS["even"]
    calibrated = calibrate(volts, RATE_HZ, P, f, np.repeat(chain(f)[None], 3, axis=0))
    record = RingDownRecord(calibrated.dmdt, RATE_HZ, "dmdt", calibrated.valid_from, calibrated.valid_to)
    result = fit_ring_down(record, "jewel")
    reference = fit_ring_down(
        RingDownRecord(clean, RATE_HZ, "dmdt"), "jewel", noise=NoiseModel.white(NOISE_SD, RATE_HZ)
    )
    truth = JEWEL.with_(**{
        n: reference.parameters[n].value for n in ("phi_max_rad", "psi_start_rad")
    })  # fmt: skip
    assert chi2.sf(joint_chi2(result, truth), 9) > 1e-3
    assert np.allclose(result.chi2_per_dof_by_channel, 1.0, atol=0.03)
    assert np.all(np.abs(errors(result, truth)) < 4 * np.sqrt(np.diag(result.covariance)))


def test_the_equaliser_is_the_inverse_in_the_signal_band_and_one_far_above():
    f = GRIDS["even"]
    equaliser = design_equaliser(f, chain(f)[None], RATE_HZ)
    n = np.arange(-equaliser.reach, equaliser.reach + 1)

    def response(frequency):
        return np.sum(equaliser.taps[0] * np.exp(-2j * np.pi * frequency / RATE_HZ * n))

    for frequency in (100.0, 213.0, 426.0, 1000.0, 3000.0, 7000.0):
        assert abs(response(frequency) * chain(frequency) - 1.0) < 1e-6
    for frequency in (18000.0, 25000.0, 30000.0):
        assert abs(response(frequency) - 1.0) < 1e-6


def test_the_equaliser_leaves_white_noise_nearly_white():
    f = GRIDS["even"]
    equaliser = design_equaliser(f, chain(f)[None], RATE_HZ)
    assert np.sum(equaliser.taps[0] ** 2) == pytest.approx(1.0, abs=0.1)


def test_every_channel_has_its_own_response():
    n = 4000
    t = np.arange(n) / RATE_HZ
    f = GRIDS["even"]
    responses = np.stack([chain(f), chain(f) ** 2, np.full(f.size, 1.3 + 0j)])
    tone = np.cos(2 * np.pi * 500.0 * t)
    gains = np.array([chain(500.0), chain(500.0) ** 2, 1.3])
    volts = np.stack([np.abs(g) * np.cos(2 * np.pi * 500.0 * t + np.angle(g)) for g in gains])
    out = calibrate(volts, RATE_HZ, -np.eye(3), f, responses)
    inside = slice(out.valid_from, out.valid_to)
    assert np.allclose(out.dmdt[:, inside], tone[inside], atol=1e-6)


def test_without_a_response_every_sample_is_valid_and_p_is_inverted_exactly():
    dm = np.random.default_rng(0).standard_normal((3, 50))
    out = calibrate(-P @ dm, RATE_HZ, P)
    assert (out.valid_from, out.valid_to) == (0, 50)
    assert np.allclose(out.dmdt, dm, rtol=0, atol=1e-12)


def test_more_than_three_channels_are_combined_by_least_squares():
    many = np.vstack([P, [[5e-4, 5e-4, 0.0], [1e-4, -3e-4, 6e-4]]])
    dm = np.random.default_rng(0).standard_normal((3, 50))
    assert np.allclose(calibrate(-many @ dm, RATE_HZ, many).dmdt, dm, rtol=0, atol=1e-11)


def test_a_response_outside_its_table_is_held_and_noted():
    f = np.linspace(100.0, 5000.0, 50)
    out = calibrate(np.zeros((3, 4000)), RATE_HZ, P, f, np.ones((3, 50), dtype=complex))
    assert len(out.notes) == 2
    assert "100 Hz" in out.notes[0]
    assert "5000 Hz" in out.notes[1]


F = np.linspace(0.0, 30000.0, 10)
ONES = np.ones((3, 10), dtype=complex)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sensitivity": np.eye(3)[:2]}, "shape"),
        ({"sensitivity": np.full((3, 3), math.nan)}, "NaN"),
        ({"sensitivity": np.ones((3, 3))}, "singular"),
        ({"sensitivity": np.zeros((3, 3))}, "singular"),
        ({"volts": np.zeros(7)}, "volts"),
        ({"volts": np.ones((3, 900)) * 1j}, "volts must be real"),
        ({"sensitivity": P + 1j}, "sensitivity must be real"),
        ({"frequency_hz": F + 1j, "frequency_response": ONES}, "frequency must be real"),
        ({"volts": np.zeros((2, 900)), "sensitivity": np.eye(3)[:2]}, "singular"),
        ({"frequency_hz": F}, "both"),
        ({"frequency_hz": F, "frequency_response": ONES[:2]}, "shape"),
        ({"frequency_hz": F[::-1], "frequency_response": ONES}, "rising"),
        ({"frequency_hz": F, "frequency_response": 0 * ONES}, "zero"),
        ({"frequency_hz": F, "frequency_response": ONES * math.nan}, "NaN"),
        ({"volts": np.zeros((3, 9)), "frequency_hz": F, "frequency_response": ONES}, "shorter"),
    ],
)
def test_a_calibration_that_cannot_be_applied_says_why(arguments, message):
    call = {"volts": np.zeros((3, 900)), "sensitivity": P, **arguments}
    with pytest.raises(CalibrationError, match=message):
        calibrate(call.pop("volts"), RATE_HZ, call.pop("sensitivity"), **call)


def test_a_calibration_error_is_a_value_error():
    assert issubclass(CalibrationError, ValueError)
