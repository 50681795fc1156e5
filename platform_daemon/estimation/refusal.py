"""Why a fit can be refused: enumerated codes, each with what was seen and what to try."""

from __future__ import annotations

from enum import Enum


class Refusal(Enum):
    """Codes of refused fits; the text says what to try."""

    NOT_FINITE = "the record contains NaN, infinite or absurdly large samples; check the reader and the calibration"
    TOO_SHORT = "the window holds too few periods; use a longer window or record"
    SATURATED = "the record is clipped; lower the gain or the excitation"
    NO_SIGNAL = "no oscillation stands out of the noise; check excitation, frequency and switch"
    SAMPLING_TOO_SLOW = "the sampling rate is below four times the oscillation frequency; lower the decimation"
    MODEL_DOES_NOT_EXPLAIN = "the model does not explain the record; check the variant and the calibration"
    TWO_RESONATORS = "the record holds a second oscillation, and the numbers would mix both; keep one resonator near"
    NO_CONVERGENCE = "the fit found no minimum; check the variant, or use another window"
    NO_DECAY = "the swing does not die away; record it from its release on, without a drive, and until its loss shows"
    AMPLITUDE_BELOW_FLOOR = "the signal is too weak for a trustworthy result; excite more or use a longer window"
    CONTACT_LOST = "the Hertz contact holds below 90 degrees only; excite less, or use a model without friction"
    OUT_OF_RANGE = "the fitted motion lies outside the range in which the model holds"


class RefusedError(Exception):
    """Ends a fit early; carries the code, the situation, and what to try where that is not as the code has it."""

    def __init__(self, code: Refusal, seen: str, advice: str = "") -> None:
        super().__init__(f"{code.name.lower()}: {seen}; {advice or code.value}")
        self.code = code
        self.seen = seen
        self.advice = advice
