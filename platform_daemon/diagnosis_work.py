"""A diagnosis from specimen to report: its fixed JSON form and its page."""

from __future__ import annotations

import html
from typing import Any

from platform_daemon.diagnosis import as_json
from platform_daemon.diagnosis.search import Progress
from platform_daemon.diagnosis_shots import Specimen, diagnose_specimen
from platform_daemon.diagnosis_text import summary_text


def diagnosed(specimen: Specimen, tell: Progress) -> tuple[dict[str, Any], str]:
    """The report as JSON and as an HTML page.  Raises NothingToDiagnoseError."""
    report = as_json(diagnose_specimen(specimen, tell))
    page = (
        f"<!DOCTYPE html><meta charset='utf-8'><title>Diagnosis</title><pre>{html.escape(summary_text(report))}</pre>"
    )
    return report, page
