"""Diagnoses as the library has them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from drivers.errors import InputError
from platform_daemon.core.recordings.evidence import file_digests
from platform_daemon.diagnosis.diagnosis_result import Diagnosis
from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.report_schema import DiagnosisReport, EffectStrength
from platform_daemon.features.diagnose.load_shots import diagnose_input, load_diagnosis_input
from platform_daemon.features.models.resolve import checked_variant

from .recording import Recording, check_recording


class DiagnosisResult:
    """What the model of a resonator lacks.

    Attributes:
        report: everything, as `platform-daemon diagnose --json` writes it.
    """

    def __init__(self, found: Diagnosis, report: DiagnosisReport) -> None:
        self._found, self.report = found, report

    @property
    def verdict(self) -> str:
        """nothing_missing, explained, partly_explained or unexplained."""
        return self.report.verdict

    @property
    def effects(self) -> dict[str, EffectStrength]:
        """The strength of each effect that was found, with its standard deviation and its unit, by the effect's id."""
        return {each.id: each.strength for each in self.report.effects}

    def text(self) -> str:
        """The summary that the command prints."""
        from platform_daemon.features.diagnose.report import summary_text

        return summary_text(self.report)

    def to_html(self, path: str | Path) -> Path:
        """Write one self-contained page with pictures at `path`; the place of it."""
        from platform_daemon.diagnosis.residual_comparison import compare_residuals
        from platform_daemon.features.diagnose.page import diagnosis_html

        target = Path(path)
        target.write_bytes(diagnosis_html(self.report, compare_residuals(self._found)))
        return target

    def __repr__(self) -> str:
        return f"<DiagnosisResult {self.verdict}: {', '.join(self.effects) or 'no effect'}>"


def diagnose(
    recordings: Recording | Sequence[Recording],
    model: str | None = None,
    *,
    terms: Sequence[str] = (),
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> DiagnosisResult:
    """Find what the model of a resonator lacks, from recordings of one specimen.

    Args:
        recordings: one, or several that are diagnosed together.
        model: the declared model; None: what the recordings say; terms: further torque terms that it has.
        progress: is called with what is done now, and the share that is done, 0 to 1.

    Raises InputError for recordings that do not belong together or of which no frame can be used.
    """
    chosen = [recordings] if isinstance(recordings, Recording | str | Path) else list(recordings)
    if not chosen:
        raise InputError("there is no recording", where="recordings", remedy="give one or several")
    for each in chosen:
        check_recording(each)
    measurements = [each.measurement for each in chosen]
    wanted = None if model is None else checked_variant(model, terms)
    found = diagnose_input(load_diagnosis_input(measurements, wanted), progress)
    files = [m.path for m in measurements if m.path.is_file()]
    return DiagnosisResult(
        found, diagnosis_report(found, files=[str(m.path) for m in measurements], recordings=file_digests(files))
    )
