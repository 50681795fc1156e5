"""The next field of a ramp: as high as overdose control allows, never more than a step, and again where in doubt.

Escalation with overdose control (Babb, Rogatko and Zacks, Statist. Med. 17 (1998) 1103): the next field is the highest
at which the chance of lying above the threshold, as far as the shots so far tell, is below `overdose_rate`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from .onset_test import OnsetTest
from .schema import RAMP_ENDS, RampBound, RampEnd, RampReason
from .threshold import ThresholdPosterior
from .z_residual import VISIBLE_AM2_PER_S, ZResidual

FieldVerdict = Literal["below", "suspected", "visible"]
_SUSPECTED = 0.05  # chance of lying above the threshold from which a field is looked at again
_LEAST_STEP = 0.2  # of a step: finer ones are not worth their shots
_SCATTER = 0.03  # relative, from shot to shot, until enough shots tell it
_PRIOR_SHOTS = 4.0  # that the scatter above is worth


@dataclass(frozen=True)
class RampPlan:
    """What a ramp may do: fields in T, chances, shots at one field at most."""

    start_t: float
    step_t: float
    max_t: float
    overdose_rate: float
    false_stop_rate: float
    most_shots: int
    bound: RampBound = "requested_limit"
    """What `max_t` is."""


@dataclass
class Escalation:
    """The state of one ramp: sizes of the z residual and their noise, per field in the order of the visits."""

    plan: RampPlan
    level: float = VISIBLE_AM2_PER_S
    seen: dict[float, list[ZResidual]] = field(default_factory=dict)
    posterior: ThresholdPosterior | None = None
    _test: OnsetTest = field(init=False)

    def __post_init__(self) -> None:
        self._test = OnsetTest(self.plan.false_stop_rate, self.level)

    def see(self, field_t: float, shots: Sequence[ZResidual]) -> None:
        """What further shots at a field have shown."""
        self.seen.setdefault(field_t, []).extend(shots)
        for shot in shots:
            self._test.see(field_t, shot.size_am2_per_s, math.hypot(shot.sd_am2_per_s, self._scatter_at(field_t)))
        if self.seen[field_t]:
            self.posterior = ThresholdPosterior.of(*self._means(), level=self.level)

    def _means(self) -> tuple[list[float], list[float], list[float]]:
        """Fields, mean sizes and standard deviations of these."""
        fields = sorted(f for f, shots in self.seen.items() if shots)
        sizes = [self.size(f) for f in fields]
        sds = [
            math.hypot(self._noise(f), self._scatter() * max(self.size(f), 0.1 * self.level))
            / math.sqrt(len(self.seen[f]))
            for f in fields
        ]
        return fields, sizes, sds

    def size(self, field_t: float) -> float:
        """Mean z residual at a field, A m^2/s."""
        return float(np.mean([s.size_am2_per_s for s in self.seen[field_t]]))

    def _noise(self, field_t: float) -> float:
        return float(np.mean([s.sd_am2_per_s for s in self.seen[field_t]]))

    def _scatter(self) -> float:
        """Relative scatter from shot to shot, pooled over all fields with several shots."""
        squares, degrees = _PRIOR_SHOTS * _SCATTER**2, _PRIOR_SHOTS
        for shots in self.seen.values():
            sizes = np.array([s.size_am2_per_s for s in shots if s.size_am2_per_s > 0.0])
            if sizes.size > 1:
                squares += float(np.sum((sizes / sizes.mean() - 1.0) ** 2))
                degrees += sizes.size - 1
        return math.sqrt(squares / degrees)

    def _scatter_at(self, field_t: float) -> float:
        return self._scatter() * max(self.size(field_t), self.level)

    def verdict(self, field_t: float) -> FieldVerdict:
        """visible: by the sequential test; suspected: the threshold may lie at or below this field."""
        if self._test.visible(field_t):
            return "visible"
        assert self.posterior is not None
        return "suspected" if self.posterior.chance_below(field_t) > _SUSPECTED else "below"

    def statistic(self, field_t: float) -> float:
        """Base-10 logarithm of the e-value of the test at a field."""
        return self._test.log_evidence(field_t) / math.log(10.0)

    def next_field(self) -> float | None:
        """The field of the next shot, T; None: the ramp has ended (`why_ended`)."""
        if self.posterior is None:  # no shot yet that can be used
            return self.plan.start_t
        decided = self.decided()
        return None if decided is None else decided[0]

    def decided(self) -> tuple[float, RampReason] | None:
        """The field of the next shot, T, and why, once a field has been seen; None: the ramp has ended."""
        here = list(self.seen)[-1]
        verdict = self.verdict(here)
        if verdict == "visible":
            return None
        again = len(self.seen[here]) < self.plan.most_shots
        if verdict == "suspected" and again:
            return here, "doubt"
        above = self._higher(max(self.seen))
        if above is None and again and here < self.plan.max_t:
            return here, "more_shots"
        return above

    def _higher(self, here: float) -> tuple[float, RampReason] | None:
        """The highest field that is allowed, at least a fifth of a step above; None: none."""
        assert self.posterior is not None
        step, most = self.plan.step_t, self.plan.max_t
        if here >= most * (1.0 - 1e-9):
            return None
        up = min(here + step, most)
        if self.posterior.chance_below(up) < self.plan.overdose_rate:
            return up, "step" if up < most else "bound"
        fine = _LEAST_STEP * step
        allowed = here + fine * math.floor((self.posterior.highest_field(self.plan.overdose_rate) - here) / fine + 1e-6)
        return (min(allowed, up), "smaller_step") if allowed >= here + 0.999 * fine else None

    @property
    def began_above(self) -> bool:
        """Side modes are visible at the first field: where they begin below it is unknown."""
        return len(self.seen) == 1 and self.verdict(next(iter(self.seen))) == "visible"

    def ended_by(self) -> RampEnd:
        """What ended the ramp, once there is no next field."""
        if self.verdict(list(self.seen)[-1]) == "visible":
            return "first_field" if self.began_above else "side_modes"
        return self.plan.bound if max(self.seen) >= self.plan.max_t * (1.0 - 1e-9) else "next_step"

    def why_ended(self) -> str:
        """The same in words."""
        end, here = self.ended_by(), 1e6 * list(self.seen)[-1]
        if end in ("first_field", "side_modes"):
            first = ", the first field: start lower" if end == "first_field" else ""
            return f"side modes are visible at {here:.4g} uT{first}"
        if end != "next_step":
            return f"no side modes up to {1e6 * self.plan.max_t:.4g} uT, {RAMP_ENDS[end]}"
        chance = f"{100 * self.plan.overdose_rate:.3g} %"
        return f"the next step would lie above the threshold with a chance of {chance} or more"

    def threshold_t(self) -> tuple[float, float, float] | None:
        """Median of the threshold and its 95 % interval, T; None: not reached, or below the first field.

        Also where it is not passed: overdose control ends a ramp below it, and then it is what the growth so far tells.
        """
        if self.posterior is None or self.began_above:
            return None
        if self.posterior.chance_below(max(self.seen) + self.plan.step_t) < self.plan.overdose_rate:
            return None
        found = [self.posterior.quantile(share) for share in (0.5, 0.025, 0.975)]
        value, low = found[0], found[1]
        if value is None or low is None:
            return None
        # Where side modes are visible the threshold lies, or below.
        top = max(self.seen) if self.verdict(list(self.seen)[-1]) == "visible" else math.inf
        high = min(found[2] if found[2] is not None else float(self.posterior.fields_t[-1]), top)
        return min(value, top), min(low, top), max(high, min(value, top))
