"""Characterisation of a resonator: the paper's tables over many shots, N50 against D30, and the data of figures."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import ConfigDict, Field, model_validator

from platform_daemon.core.schemas.base import Absent, Finite, Given, NamedWindow, Request, Schema, Vector, example
from platform_daemon.core.schemas.derived import EnvelopesReport
from platform_daemon.core.schemas.fits import FitReport
from platform_daemon.core.schemas.recordings import ExcitationInfo, Frames, RecordingId, StepName, Terms
from platform_daemon.core.schemas.requests import FieldTesla, ModelName
from platform_daemon.core.schemas.value_sources import ValueSource
from platform_daemon.features.budget.schema import BudgetReport
from platform_daemon.features.procedures.request_schema import Outcome, ProcedureRequest
from platform_daemon.features.ramp.schema import RampOutcome, RampRequest, StepTesla, check_rises
from platform_daemon.features.tune.schema import TuneOutcome, TuneRequest

SIGNIFICANCE = 0.001
"""Level of significance of the paper (ssec:primary_results)."""
Level = Annotated[float, Field(ge=1e-12, lt=0.5, allow_inf_nan=False)]
"""Of significance: of a smaller one, 1 - alpha is 1 in a float, and an interval at that level has no ends."""


class CharacterisationRequest(Request):
    """A characterisation of one resonator from shots that are stored."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"recording": "acquisition-20261121T101500-1a2b3c"}]})

    recording: RecordingId
    """Id of the recording."""
    frames: Frames = None
    """Numbers of frames, from 0, of one step; null: all, of a procedure's recording those of `step`, blank shots left
    out."""
    step: Given[StepName] = None
    """Step of a procedure's recording: its number or its name (tune, ramp, series, sweep); missing: the last
    one."""
    variant: ModelName | None = None
    """Model: thread, jewel or another declared one, or an adopted one; null: what the recording says."""
    terms: Terms = Field(default=[])
    """Further torque terms, as quadratic_drag."""
    held_in_n50: dict[str, Finite] = Field(default={})
    """Losses that are held in the N50 fits, by public name, SI; empty: of a model with several losses lambda, at the
    median of its own D30 fits."""
    alpha: Level = SIGNIFICANCE
    """Level of significance of all comparisons together, 1e-12 to 0.5."""


class ShotStatistics(Schema):
    """A quantity over the shots that have it, in the unit that its name holds."""

    shots: int
    """Shots that have it."""
    mean: float
    """Mean; of psi_start_rad on the circle."""
    std: float | None
    """Empirical standard deviation from shot to shot; null for a single shot."""
    median: float
    """Median."""
    lowest: float
    """Smallest value."""
    highest: float
    """Largest value."""


class ParameterStatistics(ShotStatistics):
    """A fitted parameter over the good shots."""

    fit_std: float | None
    """Median of the standard deviations that the fits give; null: the parameter was held."""
    systematic_std: float | None
    """The calibration's share in the error of the mean, which no number of shots makes less; null: not known."""


class RefusedShots(Schema):
    """Shots without a fit, for one reason."""

    reason: str
    """Why they were refused; of reasons that differ in their numbers only, that of the first shot."""
    frames: tuple[int, ...]
    """Their frames, from 0."""


class FitDataset(Schema):
    """The fits of all shots over one window: a row of the paper's tables."""

    window: NamedWindow
    """Evaluation window."""
    shots: int
    """Excited shots that were to be fitted."""
    good: int
    """Those with a fit."""
    refused: tuple[RefusedShots, ...]
    """Those without, by reason."""
    held: dict[str, float]
    """Parameters that were held in all fits, by public name, SI."""
    duration_s: ShotStatistics | None
    """Length T of the windows, s; null, here and below: no good fit."""
    r2: ShotStatistics | None
    """Coefficient of determination (tab:fit_results_quality: its median and smallest value)."""
    nrmse: ShotStatistics | None
    """Root mean square of the residual over that of the signal, 1 (tab:fit_results_quality)."""
    chi2_per_dof: ShotStatistics | None
    """chi^2 per degree of freedom; 1: nothing but noise is left."""
    computing_s: ShotStatistics | None
    """Computing time of a fit, s (tab:fit_results_quality)."""
    parameters: dict[str, ParameterStatistics]
    """By public name, without the orientation (tab:model_params_fit_result)."""
    orientation_error_rad: ShotStatistics | None
    """Angle to the orientation of reference, rad (tab:model_params_fit_result); null: there is no reference, or no
    calibration."""


class OrientationReference(Schema):
    """The best D30 fit: the one with the largest R² (ssec:primary_results)."""

    frame: int
    """Its frame, from 0."""
    r2: float
    """Its R²."""
    rodrigues_rad: Vector
    """Its rotation vector, rad."""


class WindowComparison(Schema):
    """A quantity in N50 against the same in D30, shot by shot."""

    quantity: str
    """Public name of the parameter, or orientation_error_rad."""
    shots: int
    """Pairs: shots that are good in both windows."""
    difference: float | None
    """Mean of N50 minus D30, in the unit that the name holds; null: nothing to compare, see `reason`."""
    low: float | None
    """Lower end of its confidence interval at 1 - alpha, before the correction for several quantities."""
    high: float | None
    """Upper end of it."""
    p_value: float | None
    """Of the paired t test: chance of a difference as large where the means are equal."""
    p_adjusted: float | None
    """The same after Holm's correction for the quantities that were tested."""
    significant: bool | None
    """Adjusted p value below alpha; null: not tested."""
    signed_rank_p_value: float | None
    """Of Wilcoxon's signed-rank test, which outliers do not move; not corrected, decides nothing."""
    lag_one_correlation: float | None
    """Of a shot's difference with that of the next shot, 1: far from 0 the shots are not independent, and the p value
    is too small; null: too few shots."""
    reason: str | None
    """Why it was not tested; null: it was."""


class ParameterUncertainty(Schema):
    """What a D30 fit of one shot is good for: a standard uncertainty, and what it is made of, in the unit of the name.

    Not of the mean: shots scatter less around a wrong mean the more of them there are.
    """

    parameter: str
    """Public name."""
    value: float
    """Mean of the D30 fits."""
    scatter: float | None
    """Standard deviation from shot to shot; null for a single shot."""
    window_difference: float | None
    """What N50 and D30 differ by on average: with a complete model nothing, so that it is the least error of the model;
    null: held in N50, or no shot is good in both."""
    systematic_std: float | None
    """The calibration's share; null: not known."""
    uncertainty: float | None
    """Root of the sum of the squares of those that are known; null: none is."""


class QualityFactors(Schema):
    """Quality factors over the good shots (tab:quality_factors); null: no shot has one."""

    n50: ShotStatistics | None
    """Equivalent Q over N50 (eq:tilde-Q), of the N50 fits, 1."""
    d30: ShotStatistics | None
    """Equivalent Q over D30, of the D30 fits, 1."""
    infinity: ShotStatistics | None
    """Equivalent Q until the motion has died, of the D30 fits, 1."""
    viscous: ShotStatistics | None
    """Q of the viscous losses alone (eq:lambda), of the D30 fits, 1."""


class CharacterisationReport(Schema):
    """What `characterise --json` writes."""

    model_config = ConfigDict(json_schema_extra=example("characterisation_report"))

    software_version: str
    """Version of the software that made it."""
    file: str
    """Path as it was named; by REST the file's name."""
    sample: str | None
    """Name of the specimen; null: the file does not say."""
    measured: str | None
    """When the first shot was made, ISO 8601; null: the file does not say."""
    variant: str
    """Model that was fitted: a declared one, with further torque terms after "+", or NAME@VERSION of an adopted one."""
    calibration: str | None
    """Identifier of the receive calibration; null: none, so that neither moment nor orientation are known."""
    excitation: ExcitationInfo | None
    """What the first of these shots was excited with (tab:measurement_parameter); null: the file does not say."""
    receive_s: float
    """Length of the receive window, s (tab:measurement_parameter)."""
    n50: FitDataset
    """The first 0.24 s of every shot."""
    d30: FitDataset
    """Every shot until 30 % of its maximum is left."""
    orientation_reference: OrientationReference | None
    """Of all orientation errors; null: no good D30 fit with a calibration."""
    alpha: float
    """Level of significance of all comparisons together."""
    comparisons: tuple[WindowComparison, ...]
    """N50 against D30, quantity by quantity."""
    uncertainties: tuple[ParameterUncertainty, ...]
    """Of every parameter of the D30 fits."""
    mean_budgets: Absent[tuple[BudgetReport, ...]] = None
    """Uncertainty budgets of the means of the D30 fits, by parameter; missing: there are none, a note says why, or an
    earlier version made the report."""
    quality_factors: QualityFactors
    """Quality factors."""
    shown_frame: int | None
    """The shot of the figures: the D30 fit with the median R²; null: there is none."""
    envelopes: tuple[EnvelopesReport, ...]
    """Of that shot over the whole receive window: by its D30 fit, then by its N50 fit; empty without a calibration."""
    value_sources: Absent[tuple[ValueSource, ...]] = None
    """Where the values of these shots come from; missing: the file does not say it of them."""
    notes: tuple[str, ...]
    """What is missing and why, and what may spoil the numbers."""
    n50_fits: FitReport
    """Shot by shot."""
    d30_fits: FitReport
    """Shot by shot."""
    seconds: float
    """Computing time of all of it, s."""


class CharacterisationBatch(Schema):
    """What `characterise --json` writes of several recordings."""

    files: tuple[CharacterisationReport, ...]
    """One entry per file, in the order in which they were named."""


class RampSettings(Request):
    """How far a ramp before a characterisation goes; what is not here is as the ramp has it."""

    start_t: FieldTesla | None = None
    """Field of the first step, T, at which there are no side modes yet; null: half that of the preset."""
    step_t: StepTesla | None = None
    """Highest step upwards, T, 1 nT to 1 mT; null: 10 uT."""
    max_t: FieldTesla | None = None
    """Field that it does not pass, T; null: the limit of the platform."""

    @model_validator(mode="after")
    def _rises(self) -> RampSettings:
        check_rises(self.start_t, self.max_t)
        return self


class CharacteriseRequest(ProcedureRequest):
    """Characterise: many shots of one resonator in one recording, and the paper's tables from them."""

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"kind": "characterise", "acquisition": {"resonator": "jewel", "shots": 100}}]}
    )

    kind: Literal["characterise"]
    """Characterise."""
    held_in_n50: dict[str, Finite] = Field(default={})
    """Losses that are held in the N50 fits, by public name, SI; empty: of a model with several losses lambda, at the
    median of its own D30 fits."""
    alpha: Level = SIGNIFICANCE
    """Level of significance of all comparisons together, 1e-12 to 0.5."""
    tune: bool = False
    """Tune first: the ramp and the shots are made with the sequence that it finds."""
    ramp: RampSettings | None = None
    """A ramp before the shots, which are made at 80 % of the field that it finds; null: none, then at the field asked
    for, that which an earlier ramp has kept with the specimen, or the preset's."""

    def tune_request(self) -> TuneRequest:
        """Tune of the same resonator, with the same keys of its sequence."""
        shots = self.acquisition
        window = "d30" if shots.window is None else shots.window
        made = shots.model_copy(update={"shots": 1, "blank_shots": 0, "window": window})
        return TuneRequest(kind="tune", acquisition=made)

    def ramp_request(self) -> RampRequest:
        """The ramp that is requested, of the same resonator."""
        assert self.ramp is not None
        shots = self.acquisition
        made = shots.model_copy(
            update={"shots": 1, "blank_shots": 0, "sequence": shots.sequence.model_copy(update={"field_t": None})}
        )
        return RampRequest(kind="ramp", acquisition=made, **self.ramp.model_dump(exclude_none=True))


class CharacteriseOutcome(Outcome):
    """What characterise has made of its shots."""

    makes_page: ClassVar[bool] = True

    kind: Literal["characterise"]
    """Characterise."""
    tune: TuneOutcome | None
    """Result of tune; null: it was not requested."""
    ramp: RampOutcome | None
    """What its ramp has found; null: it made none."""
    report: CharacterisationReport
    """What `characterise --json` writes."""
