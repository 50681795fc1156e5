"""Fits along one ring-down, window by window: with a complete model the constants are flat."""

from __future__ import annotations

from pydantic import ConfigDict

from platform_daemon.core.schemas.base import Absent, Schema, Verdict, example
from platform_daemon.core.schemas.fits import Covariance, ParameterEstimate


class WindowFitReport(Schema):
    """The fit of one window."""

    start_s: float
    """Begin of the window, s after the first RX sample."""
    end_s: float
    """Its end, s."""
    centre_s: float
    """Its middle, s."""
    verdict: Verdict
    """good or refused."""
    reason: str | None
    """Why the window was refused; null for a good one."""
    lambda_fixed: bool
    """lambda was held at the value of the D30 fit."""
    parameters: dict[str, ParameterEstimate]
    """Estimates by public name; phi_max_rad and psi_start_rad hold at start_s."""
    covariance: Absent[Covariance] = None
    """Covariance of what was estimated; missing if the window was refused."""
    chi2_per_dof: float | None
    """chi^2 per degree of freedom of the fit; 1: nothing but noise is left."""
    warnings: tuple[str, ...]
    """What may make the numbers wrong."""

    @property
    def good(self) -> bool:
        """True if there are parameters."""
        return self.verdict == "good"


class FlatnessReport(Schema):
    """Do the windows agree on one value of a parameter?  In the SI unit that its name holds."""

    mean: float
    """Weighted mean of the windows."""
    mean_sd: float
    """Its standard deviation."""
    chi2_per_dof: float
    """Scatter of the windows against their own errors; 1: they agree."""
    probability: float
    """Chance of so much scatter or more if they agree."""
    slope_per_s: float
    """Weighted straight line against the middles of the windows, unit per s."""
    slope_sd: float
    """Its standard deviation, unit per s."""
    windows: int
    """Windows that do not overlap and took part."""


class _FrameOfFile(Schema):
    file: Absent[str] = None
    """Path as it was named on the command line; else missing."""
    recording: Absent[str] = None
    """Id of the recording by REST; else missing."""
    frame: Absent[int] = None
    """Number of the frame, from 0."""


class SlidingReport(_FrameOfFile):
    """Fits along one ring-down."""

    model_config = ConfigDict(json_schema_extra=example("sliding_report"))

    window_s: float
    """Length of a window, s."""
    step_s: float
    """From window to window, s."""
    windows: tuple[WindowFitReport, ...]
    """In the order of time."""
    flatness: dict[str, FlatnessReport]
    """By public name of what a complete model keeps constant, where three windows or more tell it."""

    @property
    def good_windows(self) -> tuple[WindowFitReport, ...]:
        """Those with parameters."""
        return tuple(w for w in self.windows if w.good)
