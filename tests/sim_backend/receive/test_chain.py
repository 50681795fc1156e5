import numpy as np
import pytest

from sim_backend.options import ChainOptions
from sim_backend.receive.chain import partials, receive_v
from sim_backend.receive.response import frequency_response
from sim_backend.rotor.motion import move
from sim_backend.rotor.pieces import G_U, SPEED, START
from sim_backend.rotor.rotor import effective
from sim_backend.rotor.torque import SLOTS, STIFFNESS, parameters
from sim_backend.rotor.trajectory import states
from tests.kit.simulated_bench import CLOCK, specimen

GAUSS = np.polynomial.legendre.leggauss(40)


def chain(poles=(), delay_s=0.0):
    return ChainOptions.model_validate(
        {"poles_hz": [list(poles)] * 3, "residual_delay_s": [delay_s, 0.0, 0.0]}, strict=False
    )


def motion_of(name):
    return move(0.0, 0.08, 0.8, 30.0, parameters(effective(specimen(name)))).pieces


def emf(pieces, times, weights=(0.3, 1.0)):
    phi, phi_dot = states(pieces, times)
    return phi_dot * (weights[1] * np.cos(phi) - weights[0] * np.sin(phi))


def through_one_pole(pieces, times, pole_hz):
    """The convolution integral by Gauss quadrature between turning points, straight from angle and speed."""
    tau = 1 / (2 * np.pi * pole_hz)
    turns = pieces[pieces[:, SPEED] == 0.0, START]
    out = []
    for t in times:
        low = max(0.0, t - 40 * tau)
        edges = np.unique(np.concatenate([np.linspace(low, t, 60), turns[(turns > low) & (turns < t)]]))
        s = (edges[:-1, None] + edges[1:, None]) / 2 + (edges[1:, None] - edges[:-1, None]) / 2 * GAUSS[0]
        w = (edges[1:, None] - edges[:-1, None]) / 2 * GAUSS[1]
        order = np.argsort(s.ravel())
        s, w = s.ravel()[order], w.ravel()[order]
        out.append(np.sum(w * emf(pieces, s) * np.exp((s - t) / tau)) / tau)
    return np.array(out)


def ours(pieces, times, which):
    on = np.ones(len(pieces), dtype=np.bool_)
    return receive_v(pieces, on, times, np.array([[0.3, 1.0]] * 3), which)


@pytest.mark.parametrize("name", ["thread", "jewel"])
def test_flat_chain_gives_dm_dt_itself(name):
    pieces, times = motion_of(name), np.arange(4880) / CLOCK.rate_hz
    wanted = emf(pieces, times)
    assert np.abs(ours(pieces, times, chain())[0] - wanted).max() < 1e-9 * np.std(wanted)


@pytest.mark.parametrize("pole_hz", [300.0, 1500.0, 2500.0, 20e3, 200e3])
@pytest.mark.parametrize("name", ["thread", "jewel"])
def test_one_pole_is_exact_also_at_the_kinks_of_dry_friction(name, pole_hz):
    pieces, times = motion_of(name), np.sort(np.random.default_rng(3).uniform(0.0, 0.08, 60))
    wanted = through_one_pole(pieces, times, pole_hz)
    assert np.abs(ours(pieces, times, chain([pole_hz]))[0] - wanted).max() < 1e-8 * np.std(wanted)


def test_two_poles_are_one_after_the_other():
    pieces, times = motion_of("thread"), np.linspace(0.07, 0.08, 40)
    step = 2e-7
    fine = np.arange(0.06, 0.08, step)
    first = ours(pieces, fine, chain([20e3]))[0]
    y, second, fade = 0.0, np.empty(fine.size), np.exp(-step * 2 * np.pi * 9e3)
    for k in range(1, fine.size):
        y = fade * y + (1 - fade) * 0.5 * (first[k] + first[k - 1])
        second[k] = y
    wanted = np.interp(times, fine, second)
    assert np.abs(ours(pieces, times, chain([20e3, 9e3]))[0] - wanted).max() < 1e-4 * np.std(wanted)
    assert sum(p.weight for p in partials((20e3, 9e3, 3e3))) == pytest.approx(1.0)


def test_residual_delay_evaluates_the_signal_earlier():
    pieces, times = motion_of("jewel"), np.arange(100, 4000) / CLOCK.rate_hz
    late = ours(pieces, times, chain(delay_s=4.096e-6))
    assert np.array_equal(late[0], ours(pieces, times - 4.096e-6, chain())[0])
    assert np.array_equal(late[1], ours(pieces, times, chain())[1])


def test_what_is_applied_is_the_response_that_the_calibration_declares():
    """A rotor swinging at a thousandth of a radian is a pure tone: its phasor must change by the declared response."""
    q = np.zeros(SLOTS)
    omega = 2 * np.pi * 213.0
    q[STIFFNESS] = omega**2
    pieces = move(0.0, 0.1, 1e-3, 0.0, q).pieces
    times = np.arange(1200, 6000) / CLOCK.rate_hz
    f = omega * (1 - 1e-6 / 16) / (2 * np.pi)
    real = chain([20e3, 90e3], 4.096e-6)
    tones = np.stack([np.cos(2 * np.pi * f * times), np.sin(2 * np.pi * f * times)], 1)
    flat, seen = (
        np.linalg.lstsq(tones, receive_v(pieces, np.ones(len(pieces), bool), times, np.array([[0.0, 1.0]] * 3), c)[0],
                        rcond=None)[0] @ [1, -1j] for c in (chain(), real)
    )  # fmt: skip
    assert seen / flat == pytest.approx(frequency_response(real, np.array([f]))[0, 0], abs=2e-7)


def test_disconnected_pieces_are_silent_and_the_pole_forgets_with_its_time_constant():
    pieces = motion_of("thread")
    on = pieces[:, START] < 0.04
    times = np.array([0.0399, 0.0401, 0.0402, 0.05])
    flat = receive_v(pieces, on, times, np.array([[0.3, 1.0]] * 3), chain())[0]
    assert flat[0] != 0.0
    assert np.array_equal(flat[1:], np.zeros(3))
    poled = receive_v(pieces, on, times, np.array([[0.3, 1.0]] * 3), chain([1000.0]))[0]
    assert poled[2] / poled[1] == pytest.approx(np.exp(-1e-4 * 2 * np.pi * 1000), rel=0.2)


def test_pieces_hold_both_projections_of_the_moment():
    pieces = motion_of("jewel")
    assert pieces.shape[1] == G_U + 16
