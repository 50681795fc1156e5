"""Tune: its request and its result."""

from __future__ import annotations

from typing import Literal

from pydantic import ConfigDict

from platform_daemon.core.schemas.base import Absent, Schema
from platform_daemon.core.schemas.fits import ParameterEstimate
from platform_daemon.core.schemas.requests import FieldTesla, SequencePatch
from platform_daemon.features.procedures.request_schema import Outcome, ProcedureRequest


class TuneRequest(ProcedureRequest):
    """Tune: find the resonator's frequency, and the sequence that it is measured best with.

    Keys of `acquisition.sequence` hold for the sequence that is found; `f_tx_hz` is where the search begins, in the
    place of the design's natural frequency.
    """

    model_config = ConfigDict(
        json_schema_extra={"examples": [{"kind": "tune", "acquisition": {"resonator": "jewel"}, "max_field_t": 6e-4}]}
    )

    kind: Literal["tune"]
    """Tune."""
    weak_field_t: FieldTesla | None = None
    """Field of the first shot, T; null: a swing of some degrees by design."""
    max_field_t: FieldTesla | None = None
    """Highest field that it may raise that to, T; null: that of the platform."""
    keep: bool = True
    """Keep the sequence as the resonator's preset, where the daemon keeps presets."""


class TuneOutcome(Outcome):
    """What tune has found so far."""

    kind: Literal["tune"]
    """Tune."""
    design_f_nat_hz: float
    """Where the search began, Hz: the design's natural frequency, or f_tx_hz of the request."""
    f_nat_hz: ParameterEstimate | None
    """Natural frequency of small swings, Hz; null: not yet."""
    shots: int
    """Excited shots that it took."""
    fields_t: tuple[float, ...]
    """Their fields, T, in order."""
    lambda_per_s: ParameterEstimate | None
    """Viscous damping, 1/s; null: not yet."""
    tf_over_i_rad_per_s2: ParameterEstimate | None
    """Dry friction over moment of inertia, rad/s^2; null: not yet, or the model has none."""
    swing_rad_per_t: float | None
    """Growth of the swing per period of excitation and field, rad/T, in a weak field at f_nat; null: not yet."""
    swing_rad: float | None
    """Swing after TX that `sequence` is expected to give by it, linear, rad; null: not yet."""
    d30_s: float | None
    """Time until 30 % of that swing are left, s; the sequence listens for longer; null: not yet."""
    sequence: SequencePatch | None
    """The sequence found: f_TX, periods, field, axis, RX window, pause; null: not yet."""
    at_limits: Absent[tuple[str, ...]] = None
    """Values of `sequence` that a limit of tune has decided, and not what was measured, in words; missing: none."""
    preset: Absent[str] = None
    """NAME@VERSION under which it is kept as the resonator's preset; missing: it is not."""


class TunedPreset(Schema):
    """The sequence of a resonator that tune has found, as it is kept."""

    resonator: str
    """Name of the resonator."""
    declaration_sha256: str
    """Digest of what its file declares: for another declaration the preset does not hold."""
    date: str
    """When it was found, ISO 8601."""
    procedure: str
    """Id of the procedure that found it: its log and its recording are the evidence."""
    recording: str | None
    """Name of the recording."""
    found: TuneOutcome
    """What was found."""
