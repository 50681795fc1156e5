"""The receive chain's frequency response as a table; `chain.py` applies it to the rotor's signal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_backend.options import ChainOptions


def frequency_response(chain: ChainOptions, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Complex response (channel, k) at frequencies (k,), Hz: poles and residual delay; 1 at 0 Hz."""
    rows = []
    for poles, delay_s in zip(chain.poles_hz, chain.residual_delay_s, strict=True):
        row = np.exp(-2j * np.pi * frequency_hz * delay_s)
        for pole in poles:
            row = row / (1 + 1j * frequency_hz / pole)
        rows.append(row)
    return np.array(rows)


def is_flat(chain: ChainOptions) -> bool:
    """True if the chain changes nothing."""
    return not any(chain.poles_hz) and not any(chain.residual_delay_s)
