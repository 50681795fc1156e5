"""Signals while something else is inserted in place of the rotor: the reference dipole, or a field probe."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.tx_rx_switch import SwitchPosition
from sim_backend.options import CoilsOptions
from sim_backend.transmit.coils import pair_field_t
from sim_backend.transmit.drive import Cut

from .extra_signal import actual_chain, mixing_matrix
from .reference_dipole import Dipole
from .response import frequency_response
from .shot_setup import ShotSetup


def dipole_v(
    setup: ShotSetup, dipole: Dipole, spans: list[tuple[float, float, SwitchPosition]], times_s: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The dipole's signal at the ADC in the steady state: (channel, n), V; u = -P dm/dt (eq:u(t,p,R)).

    The transient at the start of a burst, which decays within 1 ms in the receive chain and the dipole's loop, is
    neglected.
    """
    volts = np.zeros((3, times_s.size))
    connected = np.zeros(times_s.size, dtype=np.bool_)
    for start_s, stop_s, position in spans:
        connected |= (times_s >= start_s) & (times_s < stop_s) & (position is SwitchPosition.RECEIVE)
    if (standard := dipole.table.standard) is not None and dipole.by_standard:
        heard_hz = standard.frequency_hz / (1.0 + standard.clock_error)
        _add_tone(setup, dipole, heard_hz, standard.amplitude_v, 2 * np.pi * heard_hz * times_s, connected, volts)
        return volts
    rate_hz = setup.timeline.clock.rate_hz
    for burst in setup.timeline.bursts:
        if burst.output == dipole.table.output:
            on = connected & (times_s >= burst.start_sample / rate_hz) & (times_s < burst.stop_sample / rate_hz)
            turn = 2 * np.pi * burst.frequency_hz * (times_s - burst.start_sample / rate_hz) + burst.phase_rad
            _add_tone(setup, dipole, burst.frequency_hz, burst.amplitude_v, turn, on, volts)
    return volts


def _add_tone(
    setup: ShotSetup,
    dipole: Dipole,
    frequency_hz: float,
    amplitude_v: float,
    turn: NDArray[np.float64],
    on: NDArray[np.bool_],
    volts: NDArray[np.float64],
) -> None:
    """turn: (n,) phase, rad; on: (n,) where it is heard."""
    rate_of_change = 2j * np.pi * frequency_hz * dipole.moment_per_volt_am2(frequency_hz)
    sensitivity = mixing_matrix(setup.options.hidden_effects) @ (
        setup.lna_gain * setup.sensitivity_t_per_a @ dipole.direction
    )
    chain = actual_chain(setup.options.receive.in_place(), setup.options.hidden_effects)
    response = frequency_response(chain, np.array([frequency_hz]))[:, 0]
    phasor = -sensitivity * response * rate_of_change * amplitude_v
    volts[:, on] += np.imag(phasor[:, None] * np.exp(1j * turn[on]))


def field_t(
    coils: CoilsOptions, cuts: tuple[Cut, ...], times_s: NDArray[np.float64], position_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Field of all coil currents at a point, (3, n), T, at times (n,) after the trigger."""
    per_ampere = np.stack([pair_field_t(c, axis, position_m) for axis, c in enumerate(coils.in_order())])
    total = np.zeros((3, times_s.size))
    for cut in cuts:
        inside = (times_s >= cut.start_s) & (times_s < cut.stop_s)
        for coil, field in enumerate(per_ampere):
            total[:, inside] += np.outer(field, cut.current_a(coil, times_s[inside]))
    return total
