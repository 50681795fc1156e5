"""The next measurement: what separates effects that these data cannot tell apart, ranked by what it would bring."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from .effects.base import Candidate


@dataclass(frozen=True)
class Measurement:
    """A measurement that separates effects.

    Attributes:
        key: name in an effect's `separates`.
        what: instruction for the operator.
        automatic: the platform can do it by itself.
        power: by how much it widens the difference of two effects, relative to repeating the same shots.
    """

    key: str
    what: str
    automatic: bool
    power: float


MEASUREMENTS = {
    m.key: m
    for m in (
        Measurement("second_amplitude", "repeat the series with half the excitation field", True, 3.0),
        Measurement("longer_window", "repeat the series with twice the RX window", True, 2.5),
        Measurement("more_shots", "repeat the series with four times as many shots", True, 2.0),
        Measurement("blank_shots", "record shots without excitation", True, 3.0),
        Measurement("other_excitation_axis", "excite along another axis", True, 2.0),
        Measurement("turn_90_deg", "turn the resonator by 90 degrees about z and repeat the series", False, 4.0),
        Measurement("bias_field", "apply a static bias field with a separate coil or magnet and repeat", False, 3.0),
        Measurement("calibrate_2f", "calibrate the receive chain at f and at 2 f", False, 4.0),
    )
}


@dataclass(frozen=True)
class Proposal:
    """A measurement, the ids it separates, and the difference it is expected to show, in standard deviations."""

    measurement: Measurement
    separates: tuple[str, ...]
    expected_sigma: float


def proposals(
    sets: Sequence[tuple[Candidate, Sequence[Candidate], float, float]], unexplained: float
) -> list[Proposal]:
    """Measurements for sets (effect, look-alikes, rise of chi^2 that tells them apart now, gain), the best first.

    unexplained: fall of chi^2 that something without a name would bring; more shots and other amplitudes narrow it
    down.
    """
    best: dict[str, Proposal] = {}
    for effect, alike, rise, gain in sets:
        names = tuple(dict.fromkeys([effect.effect.id, *(c.effect.id for c in alike)]))
        if len(names) < 2:
            continue
        wanted = [*effect.effect.separates, *(key for c in alike for key in c.effect.separates), "more_shots"]
        for key in dict.fromkeys(wanted):
            m = MEASUREMENTS[key]
            # What is told apart now grows with the measurement's power, as far as the effect itself is seen.
            # What shows no difference at all shows none by being repeated.
            seen = rise if key == "more_shots" else max(rise, 1.0)
            sigma = min(m.power * math.sqrt(max(seen, 0.0)), math.sqrt(gain))
            known = best.get(key)
            if known is None or sigma > known.expected_sigma:
                best[key] = Proposal(m, names, sigma)
    if unexplained > 0.0:
        for key in ("second_amplitude", "longer_window", "turn_90_deg"):
            m = MEASUREMENTS[key]
            best.setdefault(key, Proposal(m, (), math.sqrt(unexplained)))
    return sorted(best.values(), key=lambda p: -p.expected_sigma)
