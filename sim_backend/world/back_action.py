"""The back-action of the closed transmit loops on the rotor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_backend.options import SimulatedOptions
from sim_backend.rotor.rotor import Rotor


def conductance(options: SimulatedOptions, rotor: Rotor, along: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Sum of b b^T Re(1/Z) over the closed transmit loops at f_nat, (k, k), for the torques; None: effect off.

    along: (coil, k) field per ampere along u, v and, for a rigid body, w, T/A.
    The loop current that the rotor induces is taken in its steady state at f_nat; its reactive part would only shift
    the frequency by a few parts per million.
    """
    effect = options.effects.back_action
    if not effect.enabled:
        return None
    ohms = [c.resistance_ohm + options.amplifier.output_impedance_ohm for c in options.coils.in_order()]
    henries = [c.inductance_h for c in options.coils.in_order()]
    admittance = [(1 / complex(r, rotor.omega_rad_per_s * x)).real for r, x in zip(ohms, henries, strict=True)]
    return effect.scale * np.einsum("c,ci,cj->ij", np.array(admittance), along, along)
