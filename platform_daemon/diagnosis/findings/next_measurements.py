"""Measurements that separate effects that these data cannot distinguish, the best first."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.thresholds import THRESHOLDS

_LIMITS = THRESHOLDS.findings


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """A measurement that separates effects.

    Attributes:
        key: name in an effect's `separates`.
        what: instruction for the operator.
        automatic: the platform can do it by itself.
        power: where experiment_design.py has no plan for it: by how much it widens the difference of two effects.
        dipole_only: of no use for an angle.
        what_of_angles: the same for a pendulum whose angle is recorded.
    """

    key: str
    what: str
    automatic: bool = True
    power: float = 0.0
    dipole_only: bool = False
    what_of_angles: str = ""

    @property
    def planned(self) -> bool:
        """experiment_design.py computes what it would bring."""
        return self.power == 0.0


MEASUREMENTS = {
    m.key: m
    for m in (
        Measurement(
            key="second_amplitude",
            what="repeat the series with half the excitation field",
            what_of_angles="repeat the series with half the amplitude",
        ),
        Measurement(key="twice_the_field", what="repeat the series with twice the excitation field", dipole_only=True),
        Measurement(
            key="longer_window",
            what="repeat the series with twice the RX window",
            what_of_angles="record for twice the time",
        ),
        Measurement(key="more_shots", what="repeat the series with four times as many shots"),
        Measurement(key="blank_shots", what="record shots without excitation", power=_LIMITS.blank_shots_power),
        Measurement(
            key="other_excitation_axis",
            what="excite along another axis",
            power=_LIMITS.other_axis_power,
            dipole_only=True,
        ),
        Measurement(
            key="turn_90_deg",
            what="turn the resonator by 90 degrees about z and repeat the series",
            automatic=False,
            dipole_only=True,
        ),
        Measurement(
            key="on_its_side",
            what="turn the resonator by 90 degrees about x, so that gravity pulls across its main axis, and repeat",
            automatic=False,
            dipole_only=True,
        ),
        Measurement(
            key="bias_field",
            what="apply a static bias field with a separate coil or magnet and repeat",
            automatic=False,
            power=_LIMITS.bias_field_power,
            dipole_only=True,
        ),
        Measurement(
            key="calibrate_2f",
            what="calibrate the receive chain at f and at 2 f",
            automatic=False,
            power=_LIMITS.calibrate_2f_power,
            dipole_only=True,
        ),
    )
}


@dataclass(frozen=True)
class Proposal:
    """A measurement, the ids it separates, and the difference it is expected to show, in standard deviations."""

    measurement: Measurement
    separates: tuple[str, ...]
    expected_sigma: float

    def for_angles(self) -> Proposal:
        """In words for a pendulum."""
        m = self.measurement
        return replace(self, measurement=replace(m, what=m.what_of_angles or m.what))


@dataclass(frozen=True, kw_only=True)
class Ambiguity:
    """An accepted effect with its look-alikes.

    rise: of chi^2 that distinguishes them now; gain: of the effect itself; expected: measurement's key -> standard
    deviations to be expected for every look-alike, None where it cannot be computed or the shots cannot be.
    """

    effect: Candidate
    confounders: tuple[Candidate, ...]
    rise: float
    gain: float
    expected: Callable[[str], list[float] | None]


def proposals(sets: Sequence[Ambiguity], unexplained: float, *, dipole: bool = True) -> list[Proposal]:
    """Measurements that would distinguish look-alikes, the best first.

    unexplained: fall of chi^2 that something without a name would bring; more shots and other amplitudes narrow it
    down. dipole: the shots are dm/dt; an angle has neither receive chain nor axes.
    """
    best: dict[str, Proposal] = {}
    for a in sets:
        wanted = [*a.effect.effect.separates, *(k for c in a.confounders for k in c.effect.separates), "longer_window"]
        for key in dict.fromkeys([*wanted, "more_shots"]):
            found = _proposal(a, MEASUREMENTS[key])
            if found is not None and (key not in best or found.expected_sigma > best[key].expected_sigma):
                best[key] = found
    if unexplained > 0.0:
        for key in ("second_amplitude", "longer_window", "turn_90_deg"):
            best.setdefault(key, Proposal(MEASUREMENTS[key], (), math.sqrt(unexplained)))
    offered = [p if dipole else p.for_angles() for p in best.values() if dipole or not p.measurement.dipole_only]
    return sorted(offered, key=lambda p: -p.expected_sigma)


def _proposal(a: Ambiguity, m: Measurement) -> Proposal | None:
    """The look-alikes that one measurement separates, and the expected difference to the nearest of them."""
    expected = a.expected(m.key)
    if expected is None:
        if m.planned:
            return None
        # A rule of thumb: the present difference grows with the measurement's power, as far as the effect is seen.
        expected = [min(m.power * math.sqrt(max(a.rise, 1.0)), math.sqrt(a.gain))] * len(a.confounders)
    apart = [k for k, sigma in enumerate(expected) if sigma >= _LIMITS.apart_sigma] or [int(np.argmax(expected))]
    names = dict.fromkeys([a.effect.effect.id, *(a.confounders[k].effect.id for k in apart)])
    return Proposal(m, tuple(names), min(expected[k] for k in apart)) if len(names) > 1 else None
