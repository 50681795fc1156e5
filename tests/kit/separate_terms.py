"""Terms that are compiled by themselves: two that the kernels inline as well, and one whose coefficient is in s."""

from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


def separate_drag(phi, sin_phi, cos_phi, v, sigma, c, j, grad):
    grad[j] = -sigma * v * v
    return c[j] * grad[j], 0.0, -2.0 * sigma * c[j] * v


def separate_drift(phi, sin_phi, cos_phi, v, u, c, j, grad):
    excess = c[j] * u * (2.0 + c[j] * u)
    rate = 2.0 * (1.0 + c[j] * u)
    grad[j] = -sin_phi * rate * u
    return -sin_phi * excess, -cos_phi * excess, 0.0, -sin_phi * rate * c[j]


SEPARATE_DRAG = TorqueTerm(
    "separate_drag", (Coefficient("separate_drag_per_rad", "1/rad", 0, 1e-3),), separate_drag, loses_energy=True
)
SEPARATE_DRIFT = TorqueTerm(
    "separate_drift", (Coefficient("separate_drift_per_s", "1/s", 1, 1e-6),), separate_drift, timed=True
)


def cubic_drag(phi, sin_phi, cos_phi, v, sigma, c, j, grad):
    grad[j] = -v * v * v
    return c[j] * grad[j], 0.0, -3.0 * c[j] * v * v


CUBIC_DRAG = TorqueTerm("cubic_drag", (Coefficient("cubic_drag_s", "s", -1, 1e-3),), cubic_drag, loses_energy=True)
