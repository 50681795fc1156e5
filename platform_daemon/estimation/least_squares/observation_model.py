"""How the motion becomes channels: objects that give the gains of the kernel's two functions f1, f2.

    y_c(t) = gain[c, 0] f1(t) + gain[c, 1] f2(t) + offset_c

For the dipole f1 = v cos(phi), f2 = -v sin(phi) in units of w (eq:projection). Every observation knows which kernel
functions it needs (`observable`), its gains, their derivatives, and how to take a step; nothing else in the fit
depends on what is observed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array, grown
from platform_daemon.estimation.physics.rotation import (
    HALF_TURN_ABOUT_U,
    rodrigues_from_rotation,
    rodrigues_jacobian,
    rotation_from_rodrigues,
)
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE, STATE

from .normal_equations import dipole_gains


class Observation(Protocol):
    """What the fit needs to know about the channels."""

    @property
    def observable(self) -> int:
        """Which pair of kernel functions (basis_functions.py) the channels see."""

    @property
    def ties_amplitude(self) -> bool:
        """True if the ratio of f1 to f2 in the channels determines the amplitude of the motion."""

    @property
    def size(self) -> int:
        """Number of own parameters."""

    def gains(self, w: float) -> Array:
        """(channels, 2)."""

    def linear(self, w: float) -> tuple[Array, Array, Array]:
        """The gains, d gains / d w, (channels, 2), and d gains / d own parameters, (size, channels, 2)."""

    def moved(self, step: Array) -> Observation:
        """The observation after a step (size,) in its own parameters."""

    def bend(self, step: Array) -> float:
        """A step in own parameters relative to what the gains bend over."""

    def with_gains(self, gains: Array, w: float) -> Observation | None:
        """The observation with these gains (channels, 2), or None if they are not free to take any value."""

    def by_convention(self) -> tuple[Observation, bool]:
        """Resolve the exact ambiguity phi -> -phi; True if phi has to be mirrored."""

    def public(self) -> tuple[tuple[str, ...], Array, Array]:
        """(names, values (k,), Jacobian (k, size)) of the published parameters."""


@dataclass(frozen=True)
class DipoleObservation:
    """dm/dt through m_r and R, seen by channels that mix the world axes: y = mixing m_dot (eq:projection).

    Attributes:
        m_r: magnetic moment, A m^2.
        rotation: R (3, 3), columns e_u, e_v, e_w.
        mixing: (channels, 3); identity for calibrated dm/dt, -P for raw volts.
    """

    m_r: float
    rotation: Array
    mixing: Array
    observable: int = DIPOLE

    @property
    def ties_amplitude(self) -> bool:
        """u and v share m_r."""
        return True

    @property
    def size(self) -> int:
        """m_r and three local rotation angles."""
        return 4

    def gains(self, w: float) -> Array:
        """w m_r (mixing e_v, mixing e_u)."""
        return (w * self.m_r) * np.asarray(self.mixing @ self.rotation[:, 1::-1])

    def linear(self, w: float) -> tuple[Array, Array, Array]:
        """Proportional to w; by m_r and by the body-frame rotation vector delta of R exp([delta]x)."""
        mixed = self.mixing @ self.rotation
        channels = mixed.shape[0]
        out = np.empty((channels, 2)), np.empty((channels, 2)), np.empty((4, channels, 2))
        dipole_gains(mixed, w, self.m_r, *out)
        return out

    def moved(self, step: Array) -> DipoleObservation:
        """Step in m_r, as a factor, and the rotation vector (re-orthogonalised by construction)."""
        m_r = grown(self.m_r, float(step[0]))
        rotation = self.rotation @ rotation_from_rodrigues(step[1:])
        return DipoleObservation(m_r, rotation, self.mixing, self.observable)

    def bend(self, step: Array) -> float:
        """Relative change of the moment, or angle of rotation."""
        moment, *turn = step.tolist()
        return max(abs(moment / self.m_r), *map(abs, turn))

    def with_gains(self, gains: Array, w: float) -> None:
        """Tied by m_r and R."""
        return

    def by_convention(self) -> tuple[DipoleObservation, bool]:
        """e_v . x > 0: turn R by 180 degrees about u otherwise."""
        return (self, False) if self.rotation[0, 1] >= 0.0 else (self.turned(), True)

    def turned(self) -> DipoleObservation:
        """By 180 degrees about e_u: how the mirrored motion phi -> -phi gives the same signal."""
        return replace(self, rotation=self.rotation @ HALF_TURN_ABOUT_U)

    def public(self) -> tuple[tuple[str, ...], Array, Array]:
        """m_r and the Rodrigues vector."""
        rodrigues = rodrigues_from_rotation(self.rotation)
        jacobian = np.zeros((4, 4))
        jacobian[0, 0] = 1.0
        jacobian[1:, 1:] = rodrigues_jacobian(rodrigues)
        names = ("m_r_am2", "rodrigues_x", "rodrigues_y", "rodrigues_z")
        return names, np.array([self.m_r, *rodrigues]), jacobian


@dataclass(frozen=True)
class FreeGainObservation:
    """Channels with free gains: u_c = Sv_c phi' cos(phi) + Su_c (-phi' sin(phi)); no calibration is needed.

    Attributes:
        sensitivities: (channels, 2), columns Sv, Su in V s, or in A m^2 for dm/dt.
        sign: of Sv in the channel where it is largest, by convention: -1 for volts, because u = -P dm/dt.
    """

    sensitivities: Array
    sign: float = -1.0
    observable: int = DIPOLE

    @property
    def ties_amplitude(self) -> bool:
        """Gains of u and v are independent."""
        return False

    @property
    def size(self) -> int:
        """Two per channel."""
        return int(self.sensitivities.size)

    def gains(self, w: float) -> Array:
        """The kernel's functions are in units of w."""
        return w * self.sensitivities

    def linear(self, w: float) -> tuple[Array, Array, Array]:
        """Proportional to w; each gain moves its own entry."""
        by_w = np.ascontiguousarray(self.sensitivities)  # another memory order would be compiled again
        return w * by_w, by_w, w * np.eye(self.size).reshape(self.size, *by_w.shape)

    def moved(self, step: Array) -> FreeGainObservation:
        """Step in all gains."""
        return replace(self, sensitivities=self.sensitivities + step.reshape(self.sensitivities.shape))

    def bend(self, step: Array) -> float:
        """Linear, and always at their best."""
        return 0.0

    def with_gains(self, gains: Array, w: float) -> FreeGainObservation:
        """Any gains will do."""
        return replace(self, sensitivities=gains / w)

    def by_convention(self) -> tuple[FreeGainObservation, bool]:
        """The channel with the largest Sv sees it with `sign`."""
        strongest = int(np.argmax(np.abs(self.sensitivities[:, 0])))
        if self.sign * self.sensitivities[strongest, 0] >= 0.0:
            return self, False
        return self.turned(), True

    def turned(self) -> FreeGainObservation:
        """As the mirrored motion phi -> -phi gives the same signal."""
        return replace(self, sensitivities=self.sensitivities * np.array([-1.0, 1.0]))

    def public(self) -> tuple[tuple[str, ...], Array, Array]:
        """Gains are nuisance parameters: nothing to publish."""
        return (), np.empty(0), np.empty((0, self.size))


@dataclass(frozen=True)
class AngleObservation:
    """One channel that reads the angle itself; only the zero of its scale is unknown (the offset)."""

    observable: int = STATE

    @property
    def ties_amplitude(self) -> bool:
        """The amplitude is what is read."""
        return True

    @property
    def size(self) -> int:
        """No own parameters."""
        return 0

    def gains(self, w: float) -> Array:
        """One for the angle, nothing for its velocity."""
        return np.array([[1.0, 0.0]])

    def linear(self, w: float) -> tuple[Array, Array, Array]:
        """Fixed; there are no own ones."""
        return self.gains(w), np.zeros((1, 2)), np.zeros((0, 1, 2))

    def moved(self, step: Array) -> AngleObservation:
        """Nothing to move."""
        return self

    def bend(self, step: Array) -> float:
        """Nothing bends."""
        return 0.0

    def with_gains(self, gains: Array, w: float) -> None:
        """Fixed."""
        return

    def by_convention(self) -> tuple[AngleObservation, bool]:
        """The sign of the angle is seen."""
        return self, False

    def public(self) -> tuple[tuple[str, ...], Array, Array]:
        """Nothing to publish."""
        return (), np.empty(0), np.empty((0, 0))
