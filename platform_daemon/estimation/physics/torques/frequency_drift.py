"""A natural frequency that changes while the resonator rings: f_nat(t) = f_nat (1 + d t), t = 0 at the first sample.

The magnetic restoring torque goes with the square of the frequency; this is what the drift adds to it.
"""

from __future__ import annotations

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def frequency_drift(phi, law, law_phi, v, u, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -law ((1 + c u)^2 - 1) with c = d / w and u = w t; law: sin(phi), or phi of a
    linear restoring torque, with its derivative."""
    excess = c[j] * u * (2.0 + c[j] * u)
    rate = 2.0 * (1.0 + c[j] * u)
    grad[j] = -law * rate * u
    return -law * excess, -law_phi * excess, 0.0, -law * rate * c[j]


FREQUENCY_DRIFT = TorqueTerm(
    "frequency_drift", (Coefficient("frequency_drift_per_s", "1/s", 1, 1e-6),), frequency_drift, timed=True
)
