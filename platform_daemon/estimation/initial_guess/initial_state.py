"""What every search for start values returns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from platform_daemon.estimation.least_squares.gauss_newton import FitState


@dataclass(frozen=True)
class InitialState:
    """Where the fit begins.

    Attributes:
        amplitudes: candidates in rad, most trusted first.
        periods: the stretch they were seen in.
        state: the fit state that belongs to an amplitude.
    """

    amplitudes: tuple[float, ...]
    periods: float
    state: Callable[[float], FitState]
