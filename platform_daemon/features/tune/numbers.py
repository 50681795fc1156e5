"""What tune computes: how far a field should swing a resonator, and the sequence that suits what was measured."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from drivers.specimen import Specimen
from platform_daemon.design.equations import design_numbers
from platform_daemon.features.acquire.settling import time_until

BROAD_PERIODS = 3
"""A burst of so few periods has 70 % of its effect on a resonator 15 % off its frequency, 21 % at 25 % off."""
WEAK_RAD = 0.1
RINGS_PERIODS = 30
LONGEST_DEPHASING_RAD = math.pi / 2
AT_REST = 0.01
LEAST_FRICTION = 0.5
"""Of the T_f that was measured: from shot to shot it scatters by a quarter (paper, tab:model_params_fit_result)."""
LONGEST_WAIT_S = 600.0
LONGEST_RX_S = 60.0
SHORTEST_RX_S = 0.25  # n50 looks at the first 0.24 s
D30 = 0.3
MOST_SWING_RAD = math.pi / 3
HIGHEST_RAD = math.pi / 2  # no swing is taken to be larger


@dataclass(frozen=True)
class DesignExpectation:
    """By magnets and bearing alone: f_nat, Hz; growth of the swing per period and field, rad/T; weak swing, rad."""

    f_nat_hz: float
    swing_rad_per_t: float
    weak_rad: float
    tf_over_i: float


def expectation(specimen: Specimen) -> DesignExpectation:
    """Of the design; in addition, a weak swing rings for 30 periods against the dry friction.

    Driven at its frequency, a swing grows linearly by (m_r/I) B / (2 omega) per second.  Raises ValueError unless the
    rotor fits into its cup.
    """
    found = design_numbers(specimen.magnets, specimen.jewel)
    omega = 2 * math.pi * found.f_nat_hz
    tf_over_i = 0.0 if found.friction is None else found.friction.friction_rad_per_s2
    growth = found.m_r_am2 / found.inertia_kg_m2 / (2 * omega * found.f_nat_hz)
    weak_rad = weak_swing_rad(tf_over_i, found.f_nat_hz)
    return DesignExpectation(found.f_nat_hz, growth, weak_rad, tf_over_i)


def effect_beside(periods: int, f_tx_hz: float, f_nat_hz: float) -> float:
    """Effect of a burst on a resonator off its frequency, relative to that on resonance."""
    x = math.pi * periods * (f_nat_hz - f_tx_hz) / f_tx_hz
    return abs(math.sin(x) / x) if x else 1.0


def weak_swing_rad(tf_over_i: float, f_nat_hz: float) -> float:
    """A swing that a fit can use and that rings for 30 periods against dry friction, which takes 4 (T_f/I)/omega^2 of
    it in each."""
    return WEAK_RAD + RINGS_PERIODS * 4 * tf_over_i / (2 * math.pi * f_nat_hz) ** 2


@dataclass(frozen=True)
class Measured:
    """Results of the shots: f_nat, Hz; damping, 1/s; T_f/I, rad/s^2; growth of the swing per period and field
    without friction, rad/T; noise_rad: the swing whose signal has the amplitude of one sample's noise."""

    f_nat_hz: float
    lambda_per_s: float
    tf_over_i: float
    swing_rad_per_t: float
    noise_rad: float

    @property
    def omega(self) -> float:
        """Natural angular frequency, rad/s."""
        return 2 * math.pi * self.f_nat_hz

    def swing_rad(self, field_t: float, periods: int) -> float:
        """Swing after so many periods at f_nat: it grows linearly, less what dry friction takes."""
        return self.swing_rad_per_t * field_t * periods - friction_loss_rad(self.tf_over_i, self.f_nat_hz, periods)

    def field_t(self, swing_rad: float, periods: int) -> float:
        """The field that gives this swing, T."""
        lost = friction_loss_rad(self.tf_over_i, self.f_nat_hz, periods)
        return (swing_rad + lost) / (self.swing_rad_per_t * periods)

    def falls_in_s(self, start_rad: float, end_rad: float) -> float:
        """When a swing has fallen to `end_rad`, s."""
        return time_until(start_rad, end_rad, self.lambda_per_s, self.tf_over_i, self.omega)

    def slipperiest(self) -> Measured:
        """The same in a shot with so little dry friction as hardly ever comes."""
        return replace(self, tf_over_i=LEAST_FRICTION * self.tf_over_i)


def most_periods(measured: Measured, field_t: float, most_field_periods_t: float, longest_tx_s: float) -> int:
    """Whole periods of excitation, 1 at least.

    A pendulum that swings by A is slower by A^2/16; in a swing that grows linearly to A its phase falls behind by
    2 pi N A^2/48 until the N-th period ends.  As long as that is below 90 degrees, every period still pushes.
    Field times periods stays at or below that of the preset, and the linear swing below 60 degrees.
    """
    per_period = max(measured.swing_rad(field_t, 1), 1e-6)
    dephased = (LONGEST_DEPHASING_RAD * 48 / (2 * math.pi * per_period**2)) ** (1 / 3)
    bounds = (
        dephased,
        MOST_SWING_RAD / per_period,
        most_field_periods_t / field_t * (1 + 1e-9),
        longest_tx_s * measured.f_nat_hz * 0.999,
    )
    return max(1, math.floor(min(bounds)))


def friction_loss_rad(tf_over_i: float, f_nat_hz: float, periods: int) -> float:
    """What dry friction takes off a swing in so many periods, rad: 2 (T_f/I) / (pi omega) per second."""
    return tf_over_i * periods / (math.pi * f_nat_hz) ** 2


def mean_frequency_hz(f_nat_hz: float, swing_rad: float) -> float:
    """Mean frequency of a swing that grows linearly to `swing_rad`, Hz: slower by A^2/48."""
    return f_nat_hz * (1 - swing_rad**2 / 48)


def listening_s(measured: Measured, swing_rad: float, tx_s: float) -> float:
    """RX window: until the signal has the amplitude of the noise, in whole tenths; never too short for n50 and d30."""
    measured = measured.slipperiest()
    needed = (
        measured.falls_in_s(swing_rad, min(measured.noise_rad, swing_rad)),
        1.05 * measured.falls_in_s(swing_rad, D30 * swing_rad),
        5 * tx_s,  # leaves room below any usual limit of the duty
        SHORTEST_RX_S,
    )
    return math.ceil(10 * min(max(needed), LONGEST_RX_S)) / 10


def pause_s(measured: Measured, swing_rad: float, rx_s: float) -> float:
    """Wait until 1 % of the swing is left, beyond the RX window, in whole tenths."""
    rest_s = measured.slipperiest().falls_in_s(swing_rad, AT_REST * swing_rad)
    return math.ceil(10 * max(0.0, min(rest_s, LONGEST_WAIT_S) - rx_s)) / 10


def limits_reached(
    expected_rad: float, *, rx_s: float | None, pause_s: float | None, listened_s: float
) -> tuple[str, ...]:
    """Which limits of this module have decided a sequence, in words.

    expected_rad: swing without a limit; rx_s, pause_s: as they were chosen here, s, None: they were given; listened_s:
    the RX window, s.
    """
    found = []
    if expected_rad > HIGHEST_RAD:
        found.append(f"the swing is taken as {math.degrees(HIGHEST_RAD):.0f} degrees, the largest that is expected")
    if rx_s is not None and rx_s >= LONGEST_RX_S:
        found.append(f"t_RX is the longest that tune chooses, {LONGEST_RX_S:g} s: the signal lasts longer")
    if pause_s is not None and listened_s + pause_s >= LONGEST_WAIT_S:
        found.append(
            f"the next shot comes after {LONGEST_WAIT_S:g} s, the longest wait: more than 1 % of the swing is left"
        )
    return tuple(found)
