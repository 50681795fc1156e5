"""A natural frequency that settles while the resonator rings: f_nat(t) = f_nat [1 + d tau (1 - exp(-t / tau))].

It begins with the rate d and ends d tau away: warmth after a drive, a creep that comes to rest.
"""

from __future__ import annotations

import math

from platform_daemon.estimation.numerics.jit import inlined
from platform_daemon.estimation.physics.torque_term import Coefficient, TorqueTerm


@inlined
def frequency_settling(phi, law, law_phi, v, u, c, j, grad):  # type: ignore[no-untyped-def]
    """tau = -law ((1 + g)^2 - 1), g = c0 (1 - exp(-r u)) / r with c0 = d / w, r = 1 / (w tau), u = w t; law: as of
    a drift."""
    rate = c[j + 1]
    fall = math.exp(-rate * u)
    part = (1.0 - fall) / rate
    g = c[j] * part
    slope = -2.0 * law * (1.0 + g)
    grad[j] = slope * part
    grad[j + 1] = slope * c[j] * (u * fall - part) / rate
    return -law * g * (2.0 + g), -law_phi * g * (2.0 + g), 0.0, slope * c[j] * fall


FREQUENCY_SETTLING = TorqueTerm(
    "frequency_settling",
    (
        Coefficient("frequency_settling_per_s", "1/s", 1, 1e-6),
        Coefficient("frequency_settling_rate_per_s", "1/s", 1, 1e-3, hidden=True),
    ),
    frequency_settling,
    timed=True,
)
