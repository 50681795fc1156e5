"""A diagnosis from specimen to report: its fixed JSON form and its page."""

from __future__ import annotations

from typing import Any

from platform_daemon.analysis import DiagnosisInput, diagnose_input
from platform_daemon.diagnosis import ProgressCallback, as_json

from .diagnosis_page import diagnosis_html


def diagnosed(specimen: DiagnosisInput, tell: ProgressCallback) -> tuple[dict[str, Any], bytes]:
    """The report as JSON and as an HTML page.  Raises NothingToDiagnoseError."""
    found = diagnose_input(specimen, tell)
    report = as_json(found)
    return report, diagnosis_html(found, report | {"files": [f.name for f in specimen.files]})
