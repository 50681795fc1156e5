"""A certificate as one page that loads nothing from anywhere."""

from __future__ import annotations

from platform_daemon.core.reporting.page import page

from .schema import CertificateReport
from .words import TITLE, facts, known_with, result_rows, sensor_rows, sensor_statement, statement


def certificate_page(report: CertificateReport) -> bytes:
    """The page in UTF-8."""
    return page(
        "certificate_page.html",
        {"known": known_with},
        report=report,
        title=TITLE,
        facts=facts(report),
        rows=result_rows(report),
        statement=statement(report),
        sensor_rows=[] if report.sensor is None else sensor_rows(report.sensor),
        sensor_statement="" if report.sensor is None else sensor_statement(report.sensor),
    )
