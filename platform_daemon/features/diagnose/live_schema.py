"""The log of a loop on the platform: measure, diagnose, measure what is proposed, diagnose all together."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict

from platform_daemon.core.schemas.base import Absent, FiniteOrNull, Schema, Vector, example
from platform_daemon.core.schemas.fits import FileDigest
from platform_daemon.core.schemas.value_sources import ValueSource
from platform_daemon.diagnosis.report_schema import DiagnosisReport, DiagnosisVerdict, EffectStrength


class EffectSummary(Schema):
    """An accepted effect in short."""

    id: str
    """Name of the effect."""
    strength: EffectStrength
    """How strong it is."""
    indistinguishable_from: tuple[str, ...]
    """Names of effects that the data cannot tell from it."""


class _Series(Schema):
    round: int
    """Number of the round, from 1."""
    measurement: str
    """Key of the measurement; first_series: the first."""
    why: str
    """Why it was made."""
    file: str
    """Path of the recording."""
    shots: int
    """Shots on disk."""
    field_t: float
    """Excitation field at the rotor, T."""
    rx_s: float
    """RX window, s."""
    axis: Literal["x", "y", "z"] | Vector
    """Direction of the excitation."""
    expected_sigma: FiniteOrNull
    """Difference that it was expected to show, standard deviations; null: not foretold."""
    value_sources: Absent[tuple[ValueSource, ...]] = None
    """Where the values of the series come from, and the limits that hold for it."""


class _Brought(_Series):
    verdict_before: DiagnosisVerdict | None
    """Verdict of the round before; null: there was none."""
    verdict: DiagnosisVerdict
    """Verdict on all shots so far."""
    effects_before: tuple[EffectSummary, ...]
    """Effects of the round before."""
    effects: tuple[EffectSummary, ...]
    """Effects on all shots so far."""
    gain_left_over: FiniteOrNull
    """Fall of chi^2 that something without a name would still bring."""


class _Took(Schema):
    seconds: float
    """How long the round took, s."""


class DiagnosedRound(_Took, _Brought):
    """A series, and what it brought to the diagnosis."""


class UndiagnosedRound(_Took, _Series):
    """A series that was cut short, or after which nothing could be diagnosed."""


class ManualStep(Schema):
    """A step that needs a hand and was not done."""

    id: str
    """Key of the measurement."""
    what: str
    """What to do."""


class LiveDiagnosisLog(Schema):
    """What a loop on the platform measured, why, and what it brought."""

    model_config = ConfigDict(json_schema_extra=example("live_diagnosis_log"))

    stopped: str
    """Why it ended."""
    shots: int
    """Shots in all."""
    seconds: float
    """How long it took, s."""
    rounds: tuple[DiagnosedRound | UndiagnosedRound, ...]
    """Series by series."""
    manual_steps_left: tuple[ManualStep, ...]
    """What is left to do by hand."""
    recordings: tuple[FileDigest, ...]
    """What identifies the content of the recordings."""
    files: tuple[str, ...]
    """Paths of the recordings."""
    diagnosis: DiagnosisReport | None
    """The last diagnosis; null: there was none."""
