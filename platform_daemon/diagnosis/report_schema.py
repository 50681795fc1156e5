"""What a diagnosis has found: effects with their evidence, what they explain, what is left, what to measure next."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import ConfigDict, Field
from typing_extensions import TypeAliasType

from platform_daemon.core.schemas.base import Absent, FiniteOrNull, Schema, example
from platform_daemon.core.schemas.fits import Covariance, FileDigest
from platform_daemon.core.schemas.value_sources import ValueSource

DiagnosisVerdict = TypeAliasType(
    "DiagnosisVerdict", Literal["nothing_missing", "explained", "partly_explained", "unexplained"]
)
TraceRegressor = TypeAliasType("TraceRegressor", Literal["amplitude", "speed", "time"])
"""What a parameter may go with along a ring-down; speed: the largest of a swing."""
DefectKind = TypeAliasType(
    "DefectKind", Literal["clock_gap", "saturation", "duplicated_shot", "stale_samples", "not_finite"]
)
"""What can be wrong with the data themselves."""


class EffectStrength(Schema):
    """How strong an effect is."""

    value: FiniteOrNull
    """Strength in `unit`."""
    std: FiniteOrNull
    """Its standard deviation."""
    unit: str
    """Unit of both; "1": none."""


class EffectDetail(Schema):
    """Where an effect acts; null: does not apply.  Further keys are hidden scales of a torque, by public name in SI."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, FiniteOrNull] = Field(init=False)

    axis: str | None
    """The one channel it acts on: x, y or z; without a calibration its number, as in "channel 0"."""
    frequency_hz: FiniteOrNull
    """Frequency, Hz."""
    tau_s: FiniteOrNull
    """Time constant, s."""
    sample: int | None
    """First sample after a gap in the clock or a kick."""
    source: str | None = Field(validation_alias="from", serialization_alias="from")
    """Of crosstalk: the channel it comes from."""
    target: str | None = Field(validation_alias="to", serialization_alias="to")
    """Of crosstalk: the channel it goes to."""
    std: Absent[dict[str, FiniteOrNull]] = None
    """Standard deviations of the keys that were fitted, such as `tau_s`, by key; null: not determined."""

    def hidden_scales(self) -> dict[str, Any]:
        """The further keys: coefficient -> value, SI."""
        return dict(self.__pydantic_extra__ or {})


class NamedEffect(Schema):
    """An accepted effect with its evidence."""

    id: str
    """Name of the effect."""
    strength: EffectStrength
    """How strong it is."""
    detail: EffectDetail
    """Where it acts."""
    p_value: FiniteOrNull
    """Chance of such a gain if it is not there, corrected for all that were tried; 0 where it is too small."""
    held_out_gain: FiniteOrNull
    """Fall of chi^2 on held-out data that it brings; null: without it nothing could be predicted at all."""
    indistinguishable_from: tuple[str, ...]
    """Names of effects that these data cannot tell from it."""
    log10_p_value: FiniteOrNull
    """Decimal logarithm of the chance, also where it is too small for a number."""
    source: str
    """What causes it, and who described it."""
    covariance: Absent[Covariance] = None
    """Of a manufacturing error: of its strength, and of what fits with it hold beside it."""


class TentativeEffect(Schema):
    """An effect that gains, and was not accepted."""

    effect: NamedEffect
    """What it would be."""
    why_not: str
    """Why it was not accepted."""


class HeldOutErrors(Schema):
    """Errors of the prediction of data that were not used; null where nothing can be predicted."""

    nrmse_before: FiniteOrNull
    """Root mean square of the error over that of the data, of the declared model."""
    nrmse_after: FiniteOrNull
    """The same with the named effects."""
    chi2_per_dof_before: FiniteOrNull
    """chi^2 per degree of freedom of the declared model."""
    chi2_per_dof_after: FiniteOrNull
    """The same with the named effects; 1: nothing but noise is left."""
    n_shots: int
    """Shots; 1: the end of the one shot, predicted from its beginning."""


class MeanParameter(Schema):
    """Mean of a parameter over the shots, in the SI unit that its name holds."""

    value: FiniteOrNull
    """Mean."""
    std: FiniteOrNull
    """Its standard deviation."""


class WindowDisagreement(Schema):
    """How far fits of a short window (N50) and of a long one (D30) disagree; null where they cannot be compared.

    The standard error of few shots is that of their noise.  From four shots on it is that of their scatter, and the
    number is that of a normal distribution whose tail is as likely as that of Student's.
    """

    before_sigma: FiniteOrNull
    """With the declared model, standard deviations."""
    after_sigma: FiniteOrNull
    """With the named effects, standard deviations."""


class DataDefectReport(Schema):
    """Something in the data that is not as it should be."""

    id: DefectKind
    """Kind of the defect."""
    where: str
    """In words."""


class MissingTorqueMap(Schema):
    """The torque that is missing, smooth in angle and velocity, without what declared parameters absorb."""

    phi: tuple[FiniteOrNull, ...]
    """Angles, rad, (n,)."""
    phi_dot: tuple[FiniteOrNull, ...]
    """Velocities, rad/s, (m,)."""
    value: tuple[tuple[FiniteOrNull, ...], ...]
    """Torque per inertia, rad/s^2, (n, m); null where the motion never was, and where declared parameters absorb all
    that acts."""
    std: tuple[tuple[FiniteOrNull, ...], ...]
    """Its standard deviation, rad/s^2, (n, m)."""
    gain: FiniteOrNull
    """Fall of chi^2 that it would bring."""


class NextMeasurement(Schema):
    """A measurement that tells more."""

    what: str
    """What to do."""
    separates: tuple[str, ...]
    """Effects that it tells apart; empty: it narrows down what has no name."""
    expected_sigma: FiniteOrNull
    """Difference that it is expected to show, standard deviations."""


class TriedEffect(Schema):
    """A candidate by itself beside the declared model."""

    id: str
    """Name of the effect."""
    axis: str | None
    """The one channel it acts on; null: all, or none."""
    frequency_hz: FiniteOrNull
    """Frequency, Hz; null: does not apply."""
    tau_s: FiniteOrNull
    """Time constant, s; null: does not apply."""
    gain: FiniteOrNull
    """Fall of chi^2 that it brings."""
    p_value: FiniteOrNull
    """Chance of such a gain if it is not there, corrected for all that were tried."""
    sign_allowed: bool
    """Physics allows the sign of its strength."""


class UnexplainedRest(Schema):
    """What something without a name would still bring."""

    gain: FiniteOrNull
    """Fall of chi^2 beyond that of noise alone."""
    p_value: FiniteOrNull
    """Chance of so much if nothing is missing."""


class ParameterTrace(Schema):
    """A parameter along the ring-down of shots that start alike, to first order."""

    time_s: tuple[FiniteOrNull, ...]
    """Times after the first RX sample, s, (n,)."""
    amplitude_rad: tuple[FiniteOrNull, ...]
    """Amplitude of the swing there by the declared model, rad, (n,)."""
    peak_speed_rad_per_s: tuple[FiniteOrNull, ...]
    """Largest velocity of the swing there, rad/s, (n,)."""
    value: tuple[FiniteOrNull, ...]
    """The parameter there, in the SI unit that its name holds, (n,)."""
    std: tuple[FiniteOrNull, ...]
    """Its standard deviation, (n,)."""


class MovingParameter(Schema):
    """A constant of the declared model that is none along the ring-down.

    It tells where something is missing, before what.
    """

    name: str
    """Public name of the parameter; `zero_offset_rad`: the zero of an angle."""
    p_value: FiniteOrNull
    """Chance that noise alone moves it as much, beside those before it; 0 where it is too small."""
    log10_p_value: FiniteOrNull
    """Decimal logarithm of the chance, also where it is too small for a number."""
    share: FiniteOrNull
    """Share of what the declared model leaves over that its motion, with those before it, takes."""
    follows: tuple[TraceRegressor, ...]
    """What it goes with best, with what is hardly told from that; empty: no simple law of one of these."""
    rises: bool
    """It grows along the ring-down."""
    alike: tuple[str, ...]
    """Other parameters whose motion would take as much."""
    traces: tuple[ParameterTrace, ...]
    """One for each group of shots that start at like amplitudes."""


class RecordedSources(Schema):
    """Where the values of one recording come from."""

    file: str
    """Path as it was named; by REST the file's name."""
    value_sources: tuple[ValueSource, ...]
    """Values that its frames were made with, and the calibration."""


class DiagnosisReport(Schema):
    """What the declared model lacks; numbers that are not finite are null."""

    model_config = ConfigDict(json_schema_extra=example("diagnosis_report"))

    verdict: DiagnosisVerdict
    """nothing_missing: what is left is noise; explained: with the named effects it is; partly_explained: they predict
    better, but something is left; unexplained: something is missing that no effect of the library accounts for."""
    effects: tuple[NamedEffect, ...]
    """Accepted effects."""
    held_out: HeldOutErrors
    """How well data are predicted that were not used."""
    parameters_before: dict[str, MeanParameter]
    """Means with the declared model, by public name."""
    parameters_after: dict[str, MeanParameter]
    """Means with the named effects, by public name."""
    n50_d30: dict[str, WindowDisagreement]
    """How far short and long windows disagree, by public name."""
    integrity: tuple[DataDefectReport, ...]
    """What is wrong with the data themselves."""
    missing_torque: MissingTorqueMap | None
    """The torque that is missing; null: none is."""
    next_measurements: tuple[NextMeasurement, ...]
    """What to measure next, the best first."""
    seconds: float
    """Wall time, s: of a command from its start on, of a job without the reading of the files."""
    model: str
    """The declared or adopted model that was diagnosed."""
    scatter: dict[str, FiniteOrNull]
    """Scatter of the parameters from shot to shot with the named effects, by public name, SI."""
    ranking: tuple[TriedEffect, ...]
    """Every candidate by itself, the best first, 40 at most."""
    left_over: UnexplainedRest
    """What is left beside the named effects."""
    notes: tuple[str, ...]
    """What the reader should know besides."""
    where: Absent[tuple[MovingParameter, ...]] = None
    """Constants of the declared model that move along the ring-down, the one that explains most first; absent: none."""
    tentative: Absent[tuple[TentativeEffect, ...]] = None
    """Effects that gain, but were not accepted; absent where there are none."""
    model_after: Absent[str] = None
    """The model of what is called "after" everywhere here: its equation of motion with the strengths, in words."""
    files: Absent[tuple[str, ...]] = None
    """Paths as they were named; by REST the files' names."""
    value_sources: Absent[tuple[RecordedSources, ...]] = None
    """Where the values of the files come from; missing: nothing is known of any."""
    recordings: Absent[tuple[FileDigest, ...]] = None
    """What identifies the content of the files."""
