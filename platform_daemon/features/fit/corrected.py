"""On-line fits with an adopted manufacturing error: one angle, corrected by a table that is made once.

A table belongs to a model, a resonator and a sequence, and follows from these alone: it is kept beside the models, and
made again where it is missing.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from drivers.errors import RecordingError
from platform_daemon import __version__
from platform_daemon.core.recordings.recording import Recording
from platform_daemon.core.schemas.fits import CorrectionReport
from platform_daemon.core.state.durable import storage_error, write_new_file
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.physics.models import model_named
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import RefusedError
from platform_daemon.estimation.result import FitResult
from platform_daemon.estimation.rotor_correction.coordinates import OneAngle
from platform_daemon.estimation.rotor_correction.corrected_fit import corrected_fit, first_look
from platform_daemon.estimation.rotor_correction.creation import NoTableError, TableBasis, make_table
from platform_daemon.estimation.rotor_correction.table import CorrectionTable
from platform_daemon.estimation.screening.windows import Window
from platform_daemon.estimation.solve import FAILURES
from platform_daemon.estimation.thresholds import THRESHOLDS
from platform_daemon.features.models.adopted_model import AdoptedModel

from .adopted_rotor import covariance_of_adopted, reference_rotor
from .fit_request import FitRequest
from .known_moment import declared_specimen
from .rotor_context import rotor_context

LIMITS = THRESHOLDS.rotor_correction
FOLDER = "corrections"
"""Of tables, in the folder of models."""


@dataclass(frozen=True, eq=False)
class Correction:
    """A table, and what results say of it."""

    table: CorrectionTable
    report: CorrectionReport


@dataclass(frozen=True, eq=False)
class Corrections:
    """The tables of a model, a resonator and a sequence: one for each range of f_nat, which the temperature moves.

    basis: of the one at the f_nat of the diagnosis; each is made when it is first needed.
    """

    model: AdoptedModel
    basis: TableBasis
    folder: Path

    @property
    def width_hz(self) -> float:
        """Of a range."""
        return 2.0 * LIMITS.f_nat_share * self.basis.reference.f_nat_hz

    def fit(
        self, record: RingDownRecord, window: Window, noise: NoiseModel | None
    ) -> tuple[FitResult, CorrectionReport | None]:
        """See corrected_fit; and the report of the table, None where there is no result.

        Raises RecordingError where a table cannot be made, StorageError.
        """
        try:
            used, look = self._range_of(record)
        except RefusedError as refused:
            return FitResult.refused(refused), None
        except (*FAILURES, ValueError) as error:
            return FitResult("refused", reason=f"rotor_correction: {error}; {self._remedy}"), None
        found = corrected_fit(record, window, noise, used.table, look)
        if found.verdict != "good":
            return found if found.code else replace(found, reason=f"{found.reason}; {self._remedy}"), None
        errors = ", ".join(f"{name} {value:.2g}" for name, value in used.report.error.items())
        said = (
            f"one angle, corrected for {self.model.label} (table {used.report.table_sha256[:12]}); error against its "
            f"rotor of five degrees of freedom: {errors}; std contains it and the errors of what the model holds; "
            "phi_max and psi are those of one angle"
        )
        return replace(found, notes=(*found.notes, said)), used.report

    @property
    def _weight_over_pull(self) -> float:
        known = self.basis.model.parameters.get("weight_over_pull")
        return 0.0 if known is None or known.fixed is None else known.fixed

    @property
    def _remedy(self) -> str:
        return f"fit the recording with the model itself: platform-daemon fit --variant {self.model.label}"

    def _range_of(self, record: RingDownRecord) -> tuple[Correction, OneAngle]:
        """The table for the f_nat of a shot.  The search begins with the last one, which saves time and no more."""
        number = _LAST.get(self._key, 0)
        for _ in range(_MOST_LOOKS):
            used = self._numbered(number)
            look = first_look(record, used.table)
            off = round(float(look.vector[0] - used.table.start.vector[0]) / self.width_hz)
            if off == 0:
                _LAST[self._key] = number
                return used, look
            number += off
            if abs(number) > MOST_RANGES:
                far_hz = number * self.width_hz
                raise ValueError(f"f_nat is {far_hz:+.3g} Hz off that of the diagnosis: another resonator, or warmer")
        return used, look  # between two ranges: both hold it

    @cached_property
    def _key(self) -> str:
        return _digest(self.model, self.basis)

    def _numbered(self, number: int) -> Correction:
        """The table of the range so many widths above that of the diagnosis."""
        kept = self._key, number
        if kept not in _KEPT:
            if len(_KEPT) >= _MOST_KEPT:
                _KEPT.clear()
            _KEPT[kept] = self._made_or_read(number)
        return _KEPT[kept]

    def _made_or_read(self, number: int) -> Correction:
        """m_r goes with f_nat, as both magnets' moments go with the temperature."""
        reference = self.basis.reference
        share = 1.0 + number * self.width_hz / reference.f_nat_hz
        moved = {"f_nat_hz": share * reference.f_nat_hz, "m_r_am2": share * reference.m_r_am2}
        basis = replace(self.basis, reference=reference.with_numbers(moved))
        path = self.folder / FOLDER / f"{self.model.label}-{_digest(self.model, basis)[:16]}.npz"
        if not path.exists():
            try:
                content = make_table(basis).to_bytes()
            except NoTableError as error:
                raise _no_table(self.model, str(error)) from None
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise storage_error(path.parent, error) from error
            write_new_file(path, content)
        try:
            return _read(path, self.model.label, self.model.base, self._weight_over_pull)
        except (OSError, ValueError, KeyError) as error:
            raise _no_table(self.model, f"{path}: {error}", f"delete {path}, which is made again") from None


_LAST: dict[str, int] = {}
_KEPT: dict[tuple[str, int], Correction] = {}
_MOST_KEPT = 8
_MOST_LOOKS = 4
MOST_RANGES = 10
"""Above and below that of the diagnosis: 10 K of NdFeB."""


def corrections_of(recording: Recording, ask: FitRequest, first: int, folder: Path) -> Corrections:
    """For shots like the first one of a recording, with the adopted model of a request.

    first: sample that fits begin with; folder: of models.  Raises RecordingError where there can be none.
    """
    assert isinstance(ask.model, AdoptedModel)
    return Corrections(ask.model, _basis(recording, ask, first), folder)


def _read(path: Path, label: str, base: str, weight_over_pull: float) -> Correction:
    content = path.read_bytes()
    table = CorrectionTable.from_bytes(content, model_named(base).under_weight(weight_over_pull))

    def named(values: Any) -> dict[str, float]:
        return dict(zip(table.names, np.asarray(values).tolist(), strict=True))

    report = CorrectionReport(
        model=label,
        table_sha256=hashlib.sha256(content).hexdigest(),
        error=named(table.error),
        worst=named(table.worst),
        held=named(np.sqrt(np.diag(table.held))),
        left_share=table.left_share,
    )
    return Correction(table, report)


def _basis(recording: Recording, ask: FitRequest, first: int) -> TableBasis:
    """What the table follows from.  Raises RecordingError where the recording or the model does not tell it."""
    model, known, specimen = ask.model, rotor_context(recording, 0), declared_specimen(recording)
    assert isinstance(model, AdoptedModel)
    assert model.rotor is not None
    if known is None or known.drive is None or known.rotation is None or specimen is None:
        raise _no_table(model, "the correction begins at rest and follows a drive by a sine of a resonator")
    reference, error = reference_rotor(model, specimen, known.rotation), model.rotor
    names, matrix = ((), None) if error.covariance is None else covariance_of_adopted(error.covariance, drawn=True)
    sequence = recording.sequence
    return TableBasis(
        model=ask.one_angle.ring_down_model,
        geometry=known.geometry,
        reference=reference,
        drive=known.drive,
        rate_hz=sequence.rate_hz,
        samples=recording.rx_volts(0).shape[1],
        first=first,
        held_names=names,
        held_covariance=matrix,
    )


def _digest(model: AdoptedModel, basis: TableBasis) -> str:
    """Of everything that a table follows from."""
    reference = {name: np.asarray(value).tolist() for name, value in vars(basis.reference).items()}
    told = {
        "software": __version__,
        "limits": asdict(LIMITS),
        "model": model.digest,
        "base": basis.model.name,
        "weight": {name: each.fixed for name, each in basis.model.parameters.items() if each.fixed is not None},
        "geometry": asdict(basis.geometry),
        "reference": reference,
        "drive": asdict(basis.drive),
        "window": [basis.rate_hz, basis.samples, basis.first],
    }
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def _no_table(model: AdoptedModel, why: str, remedy: str = "") -> RecordingError:
    other = f"measure with --variant {model.base}, and fit the recording: platform-daemon fit --variant {model.label}"
    return RecordingError(f"{model.label} cannot be used on-line", where="variant", why=why, remedy=remedy or other)
