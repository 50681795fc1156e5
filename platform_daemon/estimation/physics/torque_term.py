"""What a torque term is: data about its coefficients, plus one compiled function with its derivatives.

Every term is a contribution to the dimensionless angular acceleration d2phi/ds2 with s = w t (w = 2 pi f_nat):

    d2phi/ds2 = sum over terms of tau(phi, v, sigma; c),   v = dphi/ds,   sigma = sign of the motion, +1 or -1

`sigma` is constant between two turning points, so tau is smooth where it is integrated. The term's function is

    tau, tau_phi, tau_v = term(phi, sin_phi, cos_phi, v, sigma, c, j, grad)

It reads its own coefficients c[j], c[j+1], ... and writes grad[j] = d tau / d c[j] for each of them. A timed term
depends on u = w t (t = 0 at the first sample) as well:

    tau, tau_phi, tau_v, tau_u = term(phi, sin_phi, cos_phi, v, u, c, j, grad)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Coefficient:
    """One physical coefficient q of a term; the kernel sees the dimensionless c = q / w**power.

    Attributes:
        name: public parameter name, with its unit.
        unit: SI unit as text.
        power: power of w (rad/s) that makes it dimensionless: 1 for 1/s, 2 for rad/s^2, -1 for s.
        typical: typical dimensionless size, used only to scale priors and first guesses.
        hidden: a scale inside the term (a velocity, a time) that must not be 0; the fit begins at the typical size.
        held: of a hidden one: a convention that the strength depends on, which no fit moves from the typical size.
    """

    name: str
    unit: str
    power: int
    typical: float
    hidden: bool = False
    held: bool = False


@dataclass(frozen=True)
class TorqueTerm:
    """One torque term.

    Attributes:
        name: identifier.
        coefficients: its coefficients, in the order in which the function reads them.
        function: the function itself, inlined or separate (torques/__init__.py).
        symmetric: tau(-phi, -v, -sigma) = -tau(phi, v, sigma), so that both directions of motion share one table.
        loses_energy: takes energy out of the motion where its first coefficient is positive.
        timed: depends on time too, which only the direct path follows.
        frozen: no derivative by its coefficients is followed; such terms come last in a model, and are timed.
        below_rad: the term holds for smaller angles only; None: for all.
    """

    name: str
    coefficients: tuple[Coefficient, ...]
    function: Callable[..., Any]
    symmetric: bool = True
    loses_energy: bool = False
    timed: bool = False
    frozen: bool = False
    below_rad: float | None = None
