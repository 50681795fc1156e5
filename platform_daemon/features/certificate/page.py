"""A certificate as one page that loads nothing from anywhere."""

from __future__ import annotations

from platform_daemon.core.reporting.page import page

from .schema import CertificateReport
from .words import TITLE, facts, result_row, sensor_rows, sensor_statement, statement


def certificate_page(report: CertificateReport) -> bytes:
    """The page in UTF-8."""
    rows = [result_row(each) for each in report.results]
    return page(
        "certificate_page.html",
        {},
        report=report,
        title=TITLE,
        facts=facts(report),
        rows=rows,
        statement=statement(report),
        sensor_rows=[] if report.sensor is None else sensor_rows(report.sensor),
        sensor_statement="" if report.sensor is None else sensor_statement(report.sensor),
    )
