"""Fits of ring-downs: a frame, a file, many files, and the ledger of a batch."""

from __future__ import annotations

from pydantic import ConfigDict

from .base import Absent, FitVerdict, NoResult, Schema, Window, example
from .derived import FrameQuantities, SeriesQuantities
from .value_sources import ValueSource


class ParameterEstimate(Schema):
    """An estimated parameter, in the SI unit that its name holds."""

    value: float
    """Estimate."""
    std: float | None
    """Standard deviation of it; null: the parameter was held, not estimated."""


class Covariance(Schema):
    """Covariance of the parameters that a fit has estimated; one that was held has no row."""

    parameters: tuple[str, ...]
    """Public names of the rows, which are those of the columns; each name holds its SI unit."""
    matrix: tuple[tuple[float, ...], ...]
    """Covariance, (parameters, parameters), in the product of the units of row and column; the diagonal is the square
    of `std`."""


class ParameterSummary(Schema):
    """A parameter over the good frames of a series, in the SI unit that its name holds."""

    mean: float
    """Mean; of psi_start_rad on the circle, of rodrigues_x, _y, _z as rotations."""
    std: float | None
    """Scatter from frame to frame; null for a single frame."""


class NoiseReport(Schema):
    """Where the noise of a fit was measured."""

    source: str | None
    """In words, as "1 blank shot"; null where nothing was fitted."""
    seconds: float
    """Computing time that it took, s, which is not in that of the fits."""


class CorrectionReport(Schema):
    """By which table a fit of one angle was corrected for an adopted manufacturing error, and how far that can be off.

    Numbers by public name, SI; turn_u_rad, turn_v_rad, turn_w_rad: of the orientation about its own axes, rad.
    """

    model: str
    """NAME@VERSION of the adopted model."""
    table_sha256: str
    """SHA-256 of the table's file, which its model, resonator and sequence tell again."""
    error: dict[str, float]
    """Root mean square error against the rotor of five degrees of freedom, of rotors that were drawn and held out;
    part of `std`."""
    worst: dict[str, float]
    """The largest of these."""
    held: dict[str, float]
    """Standard deviation that comes from what the adopted model holds; part of `std`."""
    left_share: float
    """Largest root mean square, over that of the signal, of what a correction leaves of such a rotor without noise."""


class FrameFit(Schema):
    """The fit of one frame, or why it was refused."""

    frame: int
    """Number of the frame, from 0."""
    verdict: FitVerdict
    """good: there are parameters to be trusted; refused: there are none; blank: a shot without excitation, which is not
    fitted."""
    reason: str | None
    """Why there are no parameters; null for a good frame."""
    parameters: dict[str, ParameterEstimate]
    """Estimates by public name, which holds the SI unit; empty if the frame is not good."""
    covariance: Absent[Covariance] = None
    """Covariance of what was estimated; missing if the frame is not good, and in results of earlier versions."""
    systematic_std: dict[str, float]
    """By public name: standard uncertainty that comes from the calibration alone, the same error in all frames and not
    part of `std`; empty where the calibration does not say how true it is."""
    r2: float | None
    """Coefficient of determination over all channels; 1: the model explains everything."""
    nrmse: float | None
    """Root mean square of the residual over that of the signal, all channels, 1."""
    chi2_per_dof: float | None
    """chi^2 per degree of freedom against the measured noise; 1: nothing but noise is left."""
    chi2_per_dof_by_channel: tuple[float, ...] | None
    """The same by channel, (channels,)."""
    whiteness_by_channel: tuple[float, ...] | None
    """Spectral flatness of the residual up to ten times the fundamental, against the colour of the noise: 1 for noise
    alone, near 0 where something is left over, (channels,)."""
    condition: float | None
    """Condition number of the normal equations, scaled to unit diagonal."""
    window_s: float | None
    """Fitted time span from the first RX sample on, s."""
    samples: int
    """Fitted samples per channel."""
    warnings: tuple[str, ...]
    """What may make the numbers wrong."""
    notes: tuple[str, ...]
    """What was assumed or held."""
    seconds: float
    """Computing time of the fit, s."""
    noise: NoiseReport
    """Where the noise was measured."""
    derived: Absent[FrameQuantities | NoResult] = None
    """Derived quantities, if they were requested; empty if the frame is not good."""
    correction: Absent[CorrectionReport] = None
    """Of an on-line fit with an adopted manufacturing error: one angle, corrected; missing: not corrected."""

    @property
    def good(self) -> bool:
        """True if there are parameters."""
        return self.verdict == "good"

    @property
    def blank(self) -> bool:
        """True for a shot without excitation; in results of earlier versions its verdict is "refused"."""
        return self.reason == BLANK

    @property
    def values(self) -> dict[str, float]:
        """The estimates without their errors."""
        return {name: estimate.value for name, estimate in self.parameters.items()}


BLANK = "a blank shot, without excitation"
"""Why a blank shot is not fitted."""


def unfitted(frame: int, reason: str) -> FrameFit:
    """A frame that was not offered to the fit; with the reason `BLANK` it is blank, otherwise refused."""
    return FrameFit(
        frame=frame,
        verdict="blank" if reason == BLANK else "refused",
        reason=reason,
        parameters={},
        covariance=None,
        systematic_std={},
        r2=None,
        nrmse=None,
        chi2_per_dof=None,
        chi2_per_dof_by_channel=None,
        whiteness_by_channel=None,
        condition=None,
        window_s=None,
        samples=0,
        warnings=(),
        notes=(),
        seconds=0.0,
        noise=NoiseReport(source=None, seconds=0.0),
    )


class FitReport(Schema):
    """The fits of one file."""

    model_config = ConfigDict(json_schema_extra=example("fit_report"))

    file: str
    """Path as it was named; by REST the file's name."""
    variant: str
    """Model that was fitted: a declared one, with further torque terms after "+", or NAME@VERSION of an adopted one."""
    window: Window
    """Evaluation window that was requested: n50, d30, or seconds."""
    window_s: float | None
    """Median of the windows of the good frames, s."""
    calibration: str | None
    """Identifier of the receive calibration; null: the file has none."""
    notes: tuple[str, ...]
    """What holds for all frames."""
    noise: NoiseReport
    """Where the noise of most frames was measured, and the computing time of all."""
    frames: tuple[FrameFit, ...]
    """Frame by frame."""
    summary: dict[str, ParameterSummary]
    """Mean and scatter over the good frames, by public name."""
    systematic_std: dict[str, float]
    """By public name: the calibration's share in the error of each mean, which no number of frames makes less."""
    value_sources: Absent[tuple[ValueSource, ...]] = None
    """Where the values come from that the frames were made with, and the calibration; missing: nothing is known, or the
    report of the series says it."""
    derived: Absent[SeriesQuantities] = None
    """Derived quantities of the series, if they were requested."""

    @property
    def good_frames(self) -> tuple[FrameFit, ...]:
        """Those with parameters."""
        return tuple(f for f in self.frames if f.good)

    @property
    def blank_frames(self) -> tuple[FrameFit, ...]:
        """Those without excitation."""
        return tuple(f for f in self.frames if f.blank)


class ErrorSummary(Schema):
    """An error in a list of results."""

    title: str
    """Kind of the error."""
    detail: str
    """What, where, why and the remedy, in one line."""


class FileError(Schema):
    """A file that could not be read or fitted at all."""

    file: str
    """Path as it was named."""
    error: ErrorSummary
    """What went wrong."""


class FitBatch(Schema):
    """The fits of several files, in the order in which they were named."""

    model_config = ConfigDict(json_schema_extra=example("fit_batch"))

    files: tuple[FitReport | FileError, ...]
    """One entry per file that has ended."""
    unfinished: Absent[tuple[str, ...]] = None
    """Files that had not ended when the run was interrupted; missing where all have."""


class FileDigest(Schema):
    """A file and what identifies its content."""

    file: str
    """Name of the file."""
    size_bytes: int | None
    """Size, bytes; null: it is not there any more."""
    sha256: str | None
    """SHA-256 of its content; null: it is not there any more."""


class FileState(Schema):
    """What tells that a file has changed."""

    size_bytes: int
    """Size, bytes."""
    modified_ns: int
    """Time of the last change, ns since 1970."""


class LedgerLine(Schema):
    """One line of the ledger of a batch (`fit --jsonl`): a file that has ended."""

    model_config = ConfigDict(json_schema_extra=example("ledger_line"))

    path: str
    """Absolute path."""
    input: FileState | None
    """State of the file that was read; null: it no longer exists."""
    settings: str
    """SHA-256 of everything that a result depends on, except the file."""
    report: Absent[FitReport] = None
    """What was found."""
    error: Absent[ErrorSummary] = None
    """Why nothing was; such files are tried again."""
