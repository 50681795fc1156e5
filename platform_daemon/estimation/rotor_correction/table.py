"""The correction of one-angle fits, and how it is kept."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters
from platform_daemon.estimation.screening.windows import N50_SECONDS, Window
from platform_daemon.estimation.thresholds import THRESHOLDS

from .coordinates import TURNS, OneAngle, OneAngleCoordinates
from .descent import state_of
from .motion import THIN, harmonics_of, less_harmonics, motion
from .polynomial import Box, Polynomial

CONSTANTS = ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2")
LIMITS = THRESHOLDS.rotor_correction
_POLYNOMIALS = ("to_rotor", "window_s", "to_one_angle", "from_one_angle", "harmonics")


@dataclass(frozen=True, eq=False, kw_only=True)
class Place:
    """A rotor: its vector (see `coordinates`), m_r in A m^2."""

    vector: Array
    m_r_am2: float


@dataclass(frozen=True, eq=False, kw_only=True)
class CorrectionTable:
    """What a rotor does beside one angle, and how much its constants differ from those of one angle.

    Attributes:
        coordinates: about the reference.
        rate_hz, samples: of the RX window from its first sample on; corrections end after `samples`.
        to_rotor: from the fit of the first window to the rotor, and ln of its m_r over the fitted one.
        window_s: of the rotor, when its swing has decayed to 30 %.
        to_one_angle: from the rotor to the one-angle motion beside which it is described, and ln of that one's m_r over
            the rotor's.
        from_one_angle: back, for the result.
        harmonics: of the rotor, (nodes, 3, HARMONICS), what it does beside that motion, per A m^2.
        names: of what follows: CONSTANTS that the rotor has, and its turns.
        error: (names,) root mean square error against the full model, SI, rad, of rotors that were held out.
        worst: (names,) the largest one.
        held: (names, names) covariance that comes from what an adopted model holds.
        left_share: largest root mean square, over that of the signal, of what a correction has left of a rotor that was
            held out, without noise.
        low, high: the rotors that the table is made for.
        reference_friction: T_f/I of the reference, rad/s^2; 0 without.
        start: its fit of the first window, where such fits begin.
    """

    coordinates: OneAngleCoordinates
    rate_hz: float
    samples: int
    to_rotor: Polynomial
    window_s: Polynomial
    to_one_angle: Polynomial
    from_one_angle: Polynomial
    harmonics: Polynomial
    names: tuple[str, ...]
    low: Array
    high: Array
    reference_friction: float
    start: OneAngle
    error: Array = field(default_factory=lambda: np.zeros(0))
    worst: Array = field(default_factory=lambda: np.zeros(0))
    held: Array = field(default_factory=lambda: np.zeros((0, 0)))
    left_share: float = 0.0

    def place_of(self, seen: OneAngle) -> Place:
        """The rotor that a fit of the first window tells."""
        return _moved(self.to_rotor, seen)

    def rotor_of(self, corrected: OneAngle) -> Place:
        """The rotor that a corrected fit tells."""
        return _moved(self.from_one_angle, corrected)

    def inside(self, place: Place) -> Place:
        """The nearest rotor that the table is made for: what a short window hardly tells stays near its reference."""
        return Place(vector=np.clip(place.vector, self.low, self.high), m_r_am2=place.m_r_am2)

    def outside(self, place: Place, sd: Array) -> str | None:
        """What about a rotor lies outside of the table by more than noise and the table's error allow; None: nothing.

        sd: (names,) of the noise.
        """
        losses = self.coordinates.losses
        names = ["f_nat_hz", *losses, "drive_size", "drive_delay_s", "turn_u_rad", "turn_v_rad", "turn_w_rad"]
        doubt = dict(zip(self.names, (LIMITS.outside_sigma * sd + self.worst).tolist(), strict=True))
        if self.reference_friction:
            doubt["tf_over_i_rad_per_s2"] /= self.reference_friction
        for name, value, low, high in zip(names, place.vector, self.low, self.high, strict=True):
            more = LIMITS.margin * 0.5 * (high - low) + doubt.get(name, 0.0)
            if abs(value - 0.5 * (low + high)) > more:
                logarithm = "ln of " if name in ("tf_over_i_rad_per_s2", "drive_size") else ""
                over = " over its reference" if logarithm else ""
                return f"{logarithm}{name}{over} is {value:.6g}, and the table holds {low:.6g} to {high:.6g}"
        return None

    def one_angle_of(self, place: Place) -> OneAngle:
        """The one-angle motion beside which a rotor is described."""
        *vector, bias = self.to_one_angle.at(place.vector).tolist()
        return OneAngle(np.array(vector), place.m_r_am2 * float(np.exp(bias)))

    @cached_property
    def start_state(self) -> FitState:
        """Where fits of the first window begin."""
        return state_of(self.coordinates, self.start)

    def enough(self, place: Place, window: Window) -> int:
        """Samples that hold a window of such a rotor, with a margin."""
        if window != "d30":
            return round((N50_SECONDS if window == "n50" else float(window)) * self.rate_hz) + 1
        return round(LIMITS.enough_share * float(self.window_s.at(place.vector)) * self.rate_hz)

    def taken_from(self, samples: Array, place: Place, m_r_am2: float, dynamics: MotionParameters) -> Array:
        """Samples less what a rotor does beside one angle, (3, n) A m^2/s, world axes, from the first RX sample on.

        m_r_am2, dynamics: of that one-angle motion.  Raises LostTrajectoryError where there is no such motion.
        """
        thin = -(-samples.shape[1] // THIN) + 1
        phase = harmonics_of(*motion(self.coordinates, dynamics, thin, THIN / self.rate_hz))
        return less_harmonics(samples, m_r_am2 * self.harmonics.at(place.vector), phase)

    def slope(self, corrected: OneAngle) -> Array:
        """Derivatives (names, 1 + k) of the rotor's `names` by ln m_r and by the vector of a corrected fit."""
        by_vector = self.from_one_angle.slope(corrected.vector)
        place = self.rotor_of(corrected)
        rows = np.zeros((len(self.names), 1 + corrected.vector.size))
        losses = self.coordinates.losses
        order = ["f_nat_hz", *losses]
        for k, name in enumerate(self.names):
            if name == "m_r_am2":
                rows[k] = place.m_r_am2 * np.array([1.0, *by_vector[-1]])
            elif name in order:
                scale = self.friction(place) if name == "tf_over_i_rad_per_s2" else 1.0
                rows[k, 1:] = scale * by_vector[order.index(name)]
            else:
                rows[k, 1:] = by_vector[place.vector.size - TURNS + ("u", "v", "w").index(name[5])]
        return rows

    def friction(self, place: Place) -> float:
        """T_f/I, rad/s^2; 0 without."""
        return self.reference_friction * float(np.exp(place.vector[2])) if len(self.coordinates.losses) > 1 else 0.0

    def values(self, place: Place) -> dict[str, float]:
        """The rotor's `names`."""
        known = {"f_nat_hz": place.vector[0], "m_r_am2": place.m_r_am2, "lambda_per_s": place.vector[1]}
        known |= {"tf_over_i_rad_per_s2": self.friction(place)}
        known |= dict(zip(("turn_u_rad", "turn_v_rad", "turn_w_rad"), place.vector[-TURNS:].tolist(), strict=True))
        return {name: float(known[name]) for name in self.names}

    def to_bytes(self) -> bytes:
        """As a file of numpy arrays."""
        arrays: dict[str, Array] = {"rotation": self.coordinates.rotation, "psi": np.array(self.coordinates.psi_rad)}
        for name in _POLYNOMIALS:
            p: Polynomial = getattr(self, name)
            arrays |= {f"{name}.low": p.box.low, f"{name}.high": p.box.high, f"{name}.bent": np.array(p.box.bent)}
            arrays[name] = p.coefficients.astype(np.float32) if name == "harmonics" else p.coefficients
        numbers = {
            "rate_hz": self.rate_hz,
            "samples": self.samples,
            "reference_friction": self.reference_friction,
            "left_share": self.left_share,
        }
        numbers["start_m_r_am2"] = self.start.m_r_am2
        arrays["start"] = self.start.vector
        arrays |= {name: np.array(value) for name, value in numbers.items()}
        arrays |= {name: getattr(self, name) for name in ("low", "high", "error", "worst", "held")}
        arrays["names"] = np.array(self.names)
        file = io.BytesIO()
        np.savez(file, **arrays)  # type: ignore[arg-type]
        return file.getvalue()

    @classmethod
    def from_bytes(cls, content: bytes, model: RingDownModel) -> CorrectionTable:
        """What `to_bytes` made; model: of one angle.  Raises ValueError, KeyError for anything else."""
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            found: Mapping[str, Array] = dict(file)
        polynomials = {
            name: Polynomial(Box(found[f"{name}.low"], found[f"{name}.high"], int(found[f"{name}.bent"])), found[name])
            for name in _POLYNOMIALS
        }
        return cls(
            coordinates=OneAngleCoordinates(model, found["rotation"], float(found["psi"])),
            rate_hz=float(found["rate_hz"]),
            samples=int(found["samples"]),
            to_rotor=polynomials["to_rotor"],
            window_s=polynomials["window_s"],
            to_one_angle=polynomials["to_one_angle"],
            from_one_angle=polynomials["from_one_angle"],
            harmonics=polynomials["harmonics"],
            names=tuple(found["names"].tolist()),
            low=found["low"],
            high=found["high"],
            reference_friction=float(found["reference_friction"]),
            start=OneAngle(found["start"], float(found["start_m_r_am2"])),
            error=found["error"],
            worst=found["worst"],
            held=found["held"],
            left_share=float(found["left_share"]),
        )


def _moved(polynomial: Polynomial, seen: OneAngle) -> Place:
    *vector, bias = polynomial.at(seen.vector).tolist()
    return Place(vector=np.array(vector), m_r_am2=seen.m_r_am2 * float(np.exp(bias)))
