"""Effects on the reading of an angle: a scale that is not straight, as of a camera that looks askew.

The reading is phi + q phi^2 or phi + q phi^3, from where the swing rests: a line at two or three times its frequency
that follows the square or the cube of the amplitude, while the motion itself is that of the declared model.
"""

from __future__ import annotations

from platform_daemon.diagnosis.shots.linearisation import Linearisation
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

from .effect import Candidate, Effect

_LIMITS = THRESHOLDS.effects
QUADRATIC = Effect(
    id="quadratic_nonlinearity",
    unit="1/rad",
    sign=0,
    separates=("second_amplitude",),
    signature="a line at 2 f and a middle that follow the square of the amplitude",
    source="perspective of a camera, an eccentric scale: nonlinearity of a sensor, JCGM 200:2012",
)
CUBIC = Effect(
    id="cubic_nonlinearity",
    unit="1/rad^2",
    sign=0,
    separates=("second_amplitude",),
    signature="a line at 3 f that follows the cube of the amplitude, f_nat(window) does not",
    source="a displacement read as an angle, tan or sin of it: nonlinearity of a sensor, JCGM 200:2012",
)
_POWERS = {QUADRATIC: 2, CUBIC: 3}


def reading_candidates(largest_rad: float) -> list[Candidate]:
    """Curved scales that rise everywhere up to this amplitude in rad."""
    return [_curved(effect, power, largest_rad) for effect, power in _POWERS.items()]


def _curved(effect: Effect, power: int, largest_rad: float) -> Candidate:
    def change(linearisation: Linearisation, strength: float) -> Array:
        return strength * linearisation.signal**power

    def columns(linearisation: Linearisation) -> Array:
        return (linearisation.signal**power)[None]

    largest = _LIMITS.steepest_scale / (power * largest_rad ** (power - 1))
    return Candidate(effect, columns=columns, change=change, largest=largest)
