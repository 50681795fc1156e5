"""Fits along one ring-down, window by window: what a complete model keeps constant must stay flat.

Every window is a ring-down of its own, from its own start values: what one window gets wrong, the next does not
inherit. The noise is that of the whole record.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import chdtrc

from .fit import fit_ring_down
from .noise.model import NoiseModel, estimate_noise
from .numerics.arrays import Array
from .physics.models import RingDownModel
from .record import RingDownRecord
from .result import FitResult
from .thresholds import THRESHOLDS

LIMITS = THRESHOLDS.screening

LambdaMode = Literal["auto", "free", "fixed"]
CONSTANTS = ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2")
_LAMBDA = "lambda_per_s"


class ReferenceRefusedError(ValueError):
    """The D30 fit, from which the length of the windows was to be taken, was refused."""


@dataclass(frozen=True, kw_only=True)
class SlidingBounds:
    """The most windows that are fitted, and the most samples in all of them together, which set the computing time."""

    windows: int
    samples: int


@dataclass(frozen=True, kw_only=True)
class WindowFit:
    """The fit of one window.

    Attributes:
        start_s, end_s: the window, from the first RX sample of the record on.
        fit: its result; phi_max_rad and psi_start_rad hold at start_s.
        lambda_fixed: lambda was held at the value of the D30 fit.
    """

    start_s: float
    end_s: float
    fit: FitResult
    lambda_fixed: bool = False

    @property
    def centre_s(self) -> float:
        """Middle of the window."""
        return 0.5 * (self.start_s + self.end_s)


@dataclass(frozen=True, kw_only=True)
class Flatness:
    """Do the windows agree on one value?

    Attributes:
        mean, mean_sd: weighted mean of the windows.
        chi2_per_dof, probability: of the scatter against the windows' own errors; probability: of so much or more.
        slope_per_s, slope_sd: weighted straight line against the windows' centres.
        windows: that do not overlap and took part.
    """

    mean: float
    mean_sd: float
    chi2_per_dof: float
    probability: float
    slope_per_s: float
    slope_sd: float
    windows: int


@dataclass(frozen=True, kw_only=True)
class SlidingFit:
    """Windows along one ring-down, and the D30 fit of the same record that they are compared with."""

    window_s: float
    step_s: float
    reference: FitResult
    windows: tuple[WindowFit, ...]

    def course(self, name: str) -> tuple[Array, Array, Array]:
        """(centre in s, value, standard deviation) of a parameter over the windows that determine it, (n,) each."""
        return _columns(self.windows, name)

    @property
    def constants(self) -> tuple[str, ...]:
        """Names of what a complete model keeps constant, in the fits that there are."""
        fits = [w.fit for w in self.windows if w.fit.fitted is not None]
        own = {c.name: None for fit in fits if fit.fitted is not None for c in fit.fitted.model.coefficients}
        return (*CONSTANTS, *(name for name in own if name not in CONSTANTS))

    def flatness(self, name: str) -> Flatness | None:
        """None if fewer than three windows that do not overlap determine the parameter."""
        apart = self.windows[:: max(1, math.ceil(self.window_s / self.step_s * (1.0 - 1e-9)))]
        time, value, sd = _columns(apart, name)
        if time.size < 3:
            return None
        weight = 1.0 / sd**2
        mean = float(np.average(value, weights=weight))
        scatter = float(np.sum(weight * (value - mean) ** 2))
        centred = time - np.average(time, weights=weight)
        information = float(np.sum(weight * centred**2))
        return Flatness(
            mean=mean,
            mean_sd=float(weight.sum() ** -0.5),
            chi2_per_dof=scatter / (time.size - 1),
            probability=float(chdtrc(time.size - 1, scatter)),
            slope_per_s=float(np.sum(weight * centred * value)) / information,
            slope_sd=information**-0.5,
            windows=time.size,
        )


def fit_sliding(
    record: RingDownRecord,
    variant: str | RingDownModel,
    window_s: float | None = None,
    step_s: float | None = None,
    *,
    lambda_mode: LambdaMode = "auto",
    noise: NoiseModel | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: SlidingBounds | None = None,
) -> SlidingFit:
    """Fit a ring-down window by window.

    Args:
        record: RX samples, dm/dt or volts.
        variant: a declared model by name, or any model.
        window_s: length of the windows; None: an eighth of the D30 window, at least 24 periods.
        step_s: from window to window; None: the length of a window, so that they do not overlap.
        lambda_mode: what to do with lambda where friction is fitted too. "auto": held at the D30 fit's value in those
            windows that cannot separate it from the friction; "free", "fixed": in none, in all.
        noise: measured elsewhere; None: from the record itself.
        fixed: parameters held in all windows, by name.
        bounds: the most windows and samples that are fitted; None: no bound.

    Raises:
        ValueError: lengths that are not positive or longer than the record, more windows than the bounds allow, an
            unknown variant or mode.
        ReferenceRefusedError: no length was given while the D30 fit was refused.
    """
    if lambda_mode not in ("auto", "free", "fixed"):
        raise ValueError(f"lambda_mode must be 'auto', 'free' or 'fixed', not {lambda_mode!r}")
    noise = _noise(record) if noise is None else noise
    always = dict(fixed or {})
    reference = fit_ring_down(record, variant, "d30", noise=noise, fixed=always or None)
    length = _length(reference) if window_s is None else window_s
    step = length if step_s is None else step_s
    held = _held(reference, lambda_mode)
    spans = _spans(record, length, step, bounds)
    windows = tuple(
        _fit_window(record, variant, first=first, last=last, noise=noise, held=held, always=always, mode=lambda_mode)
        for first, last in spans
    )
    return SlidingFit(window_s=length, step_s=step, reference=reference, windows=windows)


def _noise(record: RingDownRecord) -> NoiseModel | None:
    """Of the whole record; None for values that no spectrum can be made of: the fits refuse them by name."""
    return estimate_noise(record) if np.all(np.isfinite(record.valid)) else None


def _length(reference: FitResult) -> float:
    if reference.window_s is None:
        raise ReferenceRefusedError(f"the D30 fit was refused ({reference.reason})")
    shortest = LIMITS.sliding_fewest_periods / reference.parameters["f_nat_hz"].value
    return max(reference.window_s / LIMITS.sliding_windows_per_decay, shortest)


def _spans(
    record: RingDownRecord, length_s: float, step_s: float, bounds: SlidingBounds | None
) -> list[tuple[int, int]]:
    """First and last + 1 sample of every window that lies in the record whole."""
    rate, available = record.sampling_rate_hz, record.end - record.valid_from
    if not (1.0 <= length_s * rate <= available and 1.0 <= step_s * rate <= available):
        raise ValueError(f"windows and steps must be positive and within the {available / rate:.4g} s of the record")
    count = int(length_s * rate)
    windows = int((available - count) / (step_s * rate)) + 1
    if bounds is not None and (windows > bounds.windows or windows * count > bounds.samples):
        allowed = f"{bounds.windows} windows and {bounds.samples} samples in all"
        raise ValueError(f"these are {windows} windows of {count} samples; at most {allowed} are fitted at once")
    starts = (int(k * step_s * rate) for k in range(windows))
    return [(record.valid_from + first, record.valid_from + first + count) for first in starts]


def _held(reference: FitResult, mode: LambdaMode) -> dict[str, float]:
    """lambda of the reference, if there is friction too, which could hide it."""
    losses = () if reference.fitted is None else reference.fitted.model.losses
    if mode == "free" or _LAMBDA not in losses or len(losses) < 2:
        return {}
    return {_LAMBDA: reference.parameters[_LAMBDA].value}


def _fit_window(
    record: RingDownRecord,
    variant: str | RingDownModel,
    *,
    first: int,
    last: int,
    noise: NoiseModel | None,
    held: dict[str, float],
    always: dict[str, float],
    mode: LambdaMode,
) -> WindowFit:
    """Fit samples first .. last-1."""
    cut = RingDownRecord(
        record.samples[:, first:last], record.sampling_rate_hz, record.quantity, full_scale=record.full_scale
    )
    seconds = (last - first) * record.dt_s
    fixed, hold_if_inseparable = (always | held, None) if mode == "fixed" else (always, held)
    fit = fit_ring_down(
        cut, variant, seconds, noise=noise, fixed=fixed or None, hold_if_inseparable=hold_if_inseparable
    )
    return WindowFit(
        start_s=first * record.dt_s,
        end_s=last * record.dt_s,
        fit=fit,
        lambda_fixed=fit.is_fixed(_LAMBDA) or (mode == "fixed" and bool(held)),
    )


def _columns(windows: tuple[WindowFit, ...], name: str) -> tuple[Array, Array, Array]:
    rows = [(w.centre_s, w.fit.parameters[name]) for w in windows if name in w.fit.parameters]
    known = [(t, e.value, e.std) for t, e in rows if e.std is not None]
    table = np.array(known, dtype=np.float64).reshape(-1, 3)
    return table[:, 0], table[:, 1], table[:, 2]
