"""The kernel against an independent integrator, and its derivatives against differences."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from platform_daemon.estimation.moments.workspace import Workspace
from platform_daemon.estimation.physics.models import JEWEL, THREAD, model_named
from platform_daemon.estimation.physics.torques.bias_torque import BIAS_TORQUE
from platform_daemon.estimation.physics.torques.coulomb_friction import COULOMB_FRICTION
from platform_daemon.estimation.physics.torques.frequency_drift import FREQUENCY_DRIFT
from platform_daemon.estimation.physics.torques.quadratic_drag import QUADRATIC_DRAG
from platform_daemon.estimation.physics.torques.restoring_anharmonicity import RESTORING_ANHARMONICITY
from platform_daemon.estimation.physics.torques.stribeck_friction import STRIBECK_FRICTION
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE, STATE
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError, MotionParameters, Trajectory
from platform_daemon.estimation.physics.trajectory.state_at_zero import state_at_zero
from tests.kit.pendulum import half_cycles

W = 2 * math.pi * 215.5
RATE_HZ = 8000.0
THETA = 2.0


def dipole(state):
    return np.array([state[1] * np.cos(state[0]), -state[1] * np.sin(state[0])])


def thread_reference(amplitude, lam, seconds, rtol):
    s = W * np.arange(int(seconds * RATE_HZ)) / RATE_HZ + THETA
    c = lam / W
    return solve_ivp(
        lambda _, y: [y[1], -math.sin(y[0]) - 2 * c * y[1]],
        (0, s[-1]), [amplitude, 0.0], method="DOP853", rtol=rtol, atol=1e-17, t_eval=s,
    ).y  # fmt: skip


def jewel_reference(amplitude, lam, tf, seconds, rtol):
    """Half cycle by half cycle with events; at rest once friction holds the rotor at a turning point."""
    s = W * np.arange(int(seconds * RATE_HZ)) / RATE_HZ + THETA
    c0, c1 = lam / W, tf / W**2
    out = np.zeros((2, s.size))
    begin, phi, stuck_at = 0.0, amplitude, None

    def turning(_, y):
        return y[1]

    turning.terminal = True
    while begin < s[-1]:
        if abs(math.sin(phi)) <= c1 * math.cos(phi) ** (4 / 3):
            out[0, s >= begin] = phi
            stuck_at = (begin - THETA) / W
            break
        sign = -math.copysign(1.0, phi)
        turning.direction = -sign

        def rhs(_, y, sign=sign):
            friction = sign * c1 * max(math.cos(y[0]), 0.0) ** (4 / 3)
            return [y[1], -math.sin(y[0]) - 2 * c0 * y[1] - friction]

        leg = solve_ivp(
            rhs, (begin, begin + 6), [phi, 0.0], method="DOP853", rtol=rtol, atol=1e-17, events=turning,
            dense_output=True,
        )  # fmt: skip
        inside = (s >= begin) & (s < leg.t[-1])
        out[:, inside] = leg.sol(s[inside])
        begin, phi = leg.t[-1], leg.y[0, -1]
    return out, stuck_at


def relative_rms(signal, reference):
    return math.sqrt(np.sum((signal - reference) ** 2) / np.sum(reference**2))


def traced(model, dynamics, samples, observable):
    """Basis functions at the samples, every half cycle integrated."""
    last = int(samples[-1]) + 1
    return Trajectory(model, dynamics, last / RATE_HZ).basis(0, last, 1 / RATE_HZ, observable)[:, samples]


def tabulated(model, dynamics, samples, observable):
    """The same as the fit sees them: their products with one sample that is 1."""
    ones = np.ones((1, int(samples[-1]) + 1))
    work = Workspace(model)
    moments = [work.moments(dynamics, ones, int(i), int(i) + 1, 1 / RATE_HZ, observable) for i in samples]
    return np.array([m.products[0] for m in moments]).T


BOTH_WAYS = pytest.mark.parametrize("basis_of", [traced, tabulated])


def some_of(n, count=400):
    """So many samples or a few more: all phases of many half cycles, the last sample too."""
    return np.unique(np.append(np.arange(0, n, max(1, n // count)), n - 1))


@pytest.mark.parametrize(
    ("seconds", "amplitude"),
    [
        (0.5, 0.4),
        (0.5, 1.3),
        pytest.param(15.0, 0.4, marks=pytest.mark.campaign),
    ],
)
def test_a_thread_ring_down_agrees_with_dop853_to_a_billionth(seconds, amplitude):
    reference = dipole(thread_reference(amplitude, 0.2465, seconds, 3e-14))
    looser = dipole(thread_reference(amplitude, 0.2465, seconds, 1e-12))
    dynamics = MotionParameters(w=W, theta=THETA, amplitude=amplitude, values=(0.2465,))
    samples = some_of(reference.shape[1])
    for basis_of in (traced, tabulated):
        error = relative_rms(basis_of(THREAD, dynamics, samples, DIPOLE)[:2], reference[:, samples])
        print(f"thread {seconds} s {basis_of.__name__}: {error:.1e}; reference to rtol 1e-12: "
              f"{relative_rms(looser, reference):.1e}")  # fmt: skip
        assert error < 1e-9


@pytest.mark.parametrize(("model", "losses"), [(THREAD, (0.2465,)), (JEWEL, (0.2465, 1190.0))])
@pytest.mark.parametrize("degrees", range(5, 80, 5))
def test_tables_agree_with_the_integrated_motion_to_a_billionth_at_every_amplitude(model, losses, degrees):
    dynamics = MotionParameters(w=W, theta=THETA, amplitude=math.radians(degrees), values=losses)
    everything = range(0, 6000)
    looked_up = Workspace(model).basis(dynamics, 0, 6000, 1 / RATE_HZ, DIPOLE)
    assert relative_rms(looked_up[:2], traced(model, dynamics, everything, DIPOLE)[:2]) < 1e-9


@pytest.mark.parametrize("amplitude", [0.35, pytest.param(0.93, marks=pytest.mark.campaign)])
def test_a_jewel_ring_down_agrees_with_dop853_with_events_until_it_sticks(amplitude):
    reference, stuck_at = jewel_reference(amplitude, 0.2465, 1190.0, 2.0, 3e-14)
    looser, _ = jewel_reference(amplitude, 0.2465, 1190.0, 2.0, 1e-12)
    assert stuck_at is not None
    dynamics = MotionParameters(w=W, theta=THETA, amplitude=amplitude, values=(0.2465, 1190.0))
    samples = some_of(reference.shape[1])
    for basis_of in (traced, tabulated):
        signal = basis_of(JEWEL, dynamics, samples, DIPOLE)[:2]
        error = relative_rms(signal, dipole(reference[:, samples]))
        print(f"jewel {basis_of.__name__}: {error:.1e}, sticks at {stuck_at:.4f} s; reference to rtol 1e-12: "
              f"{relative_rms(dipole(looser), dipole(reference)):.1e}")  # fmt: skip
        assert error < 1e-9


def test_a_stuck_rotor_is_silent_and_so_are_its_derivatives():
    trajectory = Trajectory(JEWEL, MotionParameters(w=W, theta=THETA, amplitude=0.05, values=(0.2465, 1190.0)), 1.0)
    basis = trajectory.basis(0, 8000, 1 / RATE_HZ, DIPOLE)
    late = basis[:-1, 4000:]
    assert np.all(late == 0.0)
    assert np.any(basis[:-1, :500] != 0.0)


def test_a_rotor_that_friction_holds_from_the_start_never_moves():
    trajectory = Trajectory(JEWEL, MotionParameters(w=W, theta=THETA, amplitude=5e-4, values=(0.2465, 1190.0)), 0.1)
    state = trajectory.basis(0, 100, 1e-3, STATE)
    assert np.all(state[0] == 5e-4)
    assert np.all(state[1] == 0.0)


LOPSIDED = THREAD.with_terms("lopsided", QUADRATIC_DRAG, BIAS_TORQUE, RESTORING_ANHARMONICITY)
STRIBECK = JEWEL.with_terms("stribeck", STRIBECK_FRICTION)
DRIFTING = THREAD.with_terms("drifting", COULOMB_FRICTION, FREQUENCY_DRIFT)
SPRING = model_named("thread_small_angle").with_terms("drifting spring", FREQUENCY_DRIFT)
CONSTANT = model_named("jewel_constant_friction")
SMALL = model_named("jewel_small_angle")


def constant_friction(phi, v, sigma, s):
    return -math.sin(phi) - 2 * 0.3 / W * v - sigma * 1190.0 / W**2


def small_angle(phi, v, sigma, s):
    return -phi - 2 * 0.3 / W * v - sigma * 1190.0 / W**2


def lopsided(phi, v, sigma, s):
    beta = 0.02 * (1 - math.cos(phi))
    return -math.sin(phi) * (1 - beta) - 2 * 0.3 / W * v - 2e-3 * v * abs(v) + 9000.0 / W**2


def drifting(phi, v, sigma, s):
    return -math.sin(phi) * (1 + 0.01 * (s - THETA) / W) ** 2 - 2 * 0.3 / W * v - sigma * 900.0 / W**2


def drifting_spring(phi, v, sigma, s):
    return -phi * (1 + 0.01 * (s - THETA) / W) ** 2 - 2 * 0.3 / W * v


def stribeck(phi, v, sigma, s):
    friction = 1190.0 + 400.0 * math.exp(-abs(v) * W / 60.0)
    return -math.sin(phi) - 2 * 0.3 / W * v - sigma * friction * math.cos(phi) ** (4 / 3) / W**2


@pytest.mark.parametrize(
    ("model", "values", "torque", "ways"),
    [
        pytest.param(CONSTANT, (0.3, 1190.0), constant_friction, [traced, tabulated], marks=pytest.mark.campaign),
        pytest.param(SMALL, (0.3, 1190.0), small_angle, [traced, tabulated], marks=pytest.mark.campaign),
        pytest.param(LOPSIDED, (0.3, 2e-3, 9000.0, 0.02), lopsided, [traced, tabulated], marks=pytest.mark.long),
        (STRIBECK, (0.3, 1190.0, 400.0, 60.0), stribeck, [traced]),
        (SPRING, (0.3, 0.01), drifting_spring, [traced]),
        pytest.param(DRIFTING, (0.3, 900.0, 0.01), drifting, [traced, tabulated], marks=pytest.mark.long),
    ],
)
@pytest.mark.parametrize("amplitude", [0.9, pytest.param(-0.3, marks=pytest.mark.campaign)])
def test_further_torque_terms_agree_with_dop853_too(model, values, torque, ways, amplitude):
    samples = some_of(6000, 100)  # each of them is integrated from the start where there are no tables
    expected = half_cycles(torque, amplitude, W * samples / RATE_HZ + THETA)
    for basis_of in ways:
        found = basis_of(model, MotionParameters(w=W, theta=THETA, amplitude=amplitude, values=values), samples, STATE)[
            :2
        ]
        error = relative_rms(found, expected)
        print(model.name, basis_of.__name__, amplitude, f"{error:.1e}")
        assert error < 2e-9


@pytest.mark.parametrize("degrees", [100.0, 140.0, 168.0])
@BOTH_WAYS
def test_wide_swings_of_a_pendulum_agree_with_dop853(degrees, basis_of):
    model = model_named("jewel_constant_friction")

    def torque(phi, v, sigma, s):
        return -math.sin(phi) - 2 * 0.01 * v - sigma * 2e-3

    samples = some_of(1200)
    amplitude = math.radians(degrees)
    expected = half_cycles(torque, amplitude, W * samples / RATE_HZ + THETA)
    found = basis_of(
        model, MotionParameters(w=W, theta=THETA, amplitude=amplitude, values=(0.01 * W, 2e-3 * W**2)), samples, STATE
    )[:2]
    print(degrees, basis_of.__name__, f"{relative_rms(found, expected):.1e}")
    assert relative_rms(found, expected) < 1e-7


@pytest.mark.parametrize(
    ("model", "values", "amplitude"),
    [
        (THREAD, (0.3,), 0.5),
        pytest.param(THREAD, (0.3,), -1.2, marks=pytest.mark.campaign),
        pytest.param(JEWEL, (0.3, 1190.0), 0.9, marks=pytest.mark.campaign),
        (JEWEL, (0.3, 1190.0), -0.3),
        (LOPSIDED, (0.3, 2e-3, 9000.0, 0.02), 0.6),
        (STRIBECK, (0.3, 1190.0, 400.0, 60.0), 0.7),
        pytest.param(SPRING, (0.3, 0.01), 0.8, marks=pytest.mark.long),
        # Differences of a motion without tables take a minute.
        pytest.param(DRIFTING, (0.3, 900.0, 0.01), -0.8, marks=pytest.mark.campaign),
    ],
)
@pytest.mark.parametrize("observable", [DIPOLE, STATE])
@BOTH_WAYS
def test_sensitivities_agree_with_differences_across_turning_points(model, values, amplitude, observable, basis_of):
    base = np.array([THETA, W, amplitude, *values])
    samples = some_of(3000, 100)
    n = samples.size

    def functions(p):
        return basis_of(
            model, MotionParameters(w=p[1], theta=p[0], amplitude=p[2], values=tuple(p[3:])), samples, observable
        )

    d = MotionParameters(w=W, theta=THETA, amplitude=amplitude, values=values)
    chain = d.chain(model)
    at = functions(base)
    exact = at[2:-1].reshape(-1, 2, n)
    exact = np.einsum("pfn,pq->qfn", exact, chain)
    for k, size in enumerate([1e-5, 1e-5, 1e-5, *(1e-5 * max(abs(q), 1e-2) for q in values)]):
        up, down = base.copy(), base.copy()
        up[k] += size
        down[k] -= size
        difference = (functions(up)[:2] - functions(down)[:2]) / (2 * size)
        scale = np.sqrt(np.mean(difference**2))
        assert np.sqrt(np.mean((exact[k] - difference) ** 2)) < 2e-4 * scale, f"parameter {k}"


@pytest.mark.parametrize("dynamics", [
    MotionParameters(w=W, theta=THETA, amplitude=3.1, values=(0.2,)),
    MotionParameters(w=W, theta=THETA, amplitude=0.4, values=(5.0 * W,)),
    MotionParameters(w=W, theta=-4.0, amplitude=0.4, values=(0.2,)),
        MotionParameters(w=W, theta=-20.0, amplitude=0.4, values=(0.2,)),
    MotionParameters(w=W, theta=THETA, amplitude=math.nan, values=(0.2,)),
])  # fmt: skip
def test_parameters_that_describe_no_oscillation_are_reported_as_lost(dynamics):
    with pytest.raises(LostTrajectoryError):
        Trajectory(THREAD, dynamics, 0.1)


@pytest.mark.parametrize("observable", [DIPOLE, STATE])
@BOTH_WAYS
def test_the_anchor_may_be_the_turning_point_after_the_first_sample_as_well(basis_of, observable):
    """The same motion from the turning point before t = 0 and from the one after it."""
    before = MotionParameters(w=W, theta=THETA, amplitude=0.9, values=(0.3, 1190.0))
    trajectory = Trajectory(JEWEL, before, 0.01)
    start, amplitude = trajectory._heads[1, 0], trajectory._nodes[1, 0, 0]  # noqa: SLF001 its second turning point
    after = MotionParameters(w=W, theta=THETA - start, amplitude=float(amplitude), values=(0.3, 1190.0))
    assert after.theta < 0.0
    samples = np.arange(200)
    late, early = (basis_of(JEWEL, d, samples, observable) for d in (after, before))
    assert np.allclose(late[:2], early[:2], rtol=0.0, atol=1e-9)
    assert np.allclose(late[2:6], early[2:6], rtol=0.0, atol=1e-8)
    for k, size in enumerate([1e-5, 1e-5, 1e-5]):
        p = np.array([after.theta, W, after.amplitude])
        up, down = p + size * np.eye(3)[k], p - size * np.eye(3)[k]
        ends = [
            basis_of(
                JEWEL, MotionParameters(w=q[1], theta=q[0], amplitude=q[2], values=after.values), samples, observable
            )[:2]
            for q in (up, down)
        ]
        slope = np.einsum("pfn,p->fn", late[2:-1].reshape(-1, 2, 200), after.chain(JEWEL)[:, k])
        assert np.allclose(slope, (ends[0] - ends[1]) / (2 * size), rtol=0.0, atol=3e-4 * np.max(np.abs(slope)))


@pytest.mark.parametrize(
    ("name", "values"), [("jewel", (0.25, 1190.0)), ("thread+bias_torque", (0.25, 900.0)), ("undamped", ())]
)
@pytest.mark.parametrize("theta", [0.0, 0.7, 2.3, 4.5, 9.0, -0.4])
@pytest.mark.parametrize("amplitude", [0.9, -0.3, 5e-3, 1e-3])  # the last rests before it crosses zero
def test_the_state_at_zero_and_its_derivatives_are_those_of_the_direct_path(name, values, amplitude, theta):
    model, d = model_named(name), MotionParameters(w=W, theta=theta, amplitude=amplitude, values=values)
    state, by_motion = state_at_zero(model, d)
    basis = Trajectory(model, d, 0.0).basis(0, 1, 1.0, STATE)[:, 0]
    np.testing.assert_allclose(state, basis[:2], rtol=1e-9, atol=1e-9 * abs(amplitude))
    np.testing.assert_allclose(by_motion, basis[2:-1].reshape(-1, 2), rtol=1e-7, atol=1e-8)


def test_a_state_beyond_the_last_turning_point_is_lost():
    with pytest.raises(LostTrajectoryError):
        state_at_zero(THREAD, MotionParameters(w=W, theta=2.0, amplitude=3.1, values=(0.25,)))
