"""A diagnosis from specimen to report: its fixed JSON form and its page."""

from __future__ import annotations

from typing import Any

from platform_daemon.analysis.diagnose import DiagnosisInput, diagnose_input
from platform_daemon.diagnosis import as_json
from platform_daemon.diagnosis.selection.stepwise import ProgressCallback

from .diagnosis_page import diagnosis_page


def diagnosed(specimen: DiagnosisInput, tell: ProgressCallback) -> tuple[dict[str, Any], bytes]:
    """The report as JSON and as an HTML page.  Raises NothingToDiagnoseError."""
    found = diagnose_input(specimen, tell)
    report = as_json(found)
    return report, diagnosis_page(found, report | {"files": [f.name for f in specimen.files]})
