"""A certificate in words: the same for page and PDF."""

from __future__ import annotations

import math

from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.features.budget.schema import BudgetReport

from .schema import CertificateReport

TITLE = "Calibration certificate"


def facts(report: CertificateReport) -> list[tuple[str, str]]:
    """What stands before the results."""
    measured = report.measured_from
    if report.measured_to != report.measured_from:
        measured += f" to {report.measured_to}"
    at = (
        "not measured" if report.temperature_c is None else f"{report.temperature_c:.2f} °C, to which the values belong"
    )
    return [
        ("Number", report.number),
        ("Issued", report.issued),
        ("Laboratory", ", ".join((report.laboratory.name, report.laboratory.city, report.laboratory.country))),
        ("Customer", ", ".join((report.customer.name, report.customer.city, report.customer.country))),
        ("Item", f"{report.item} ({report.variant} bearing)" + (f", {report.sample}" if report.sample else "")),
        ("Measured", f"{measured}, {report.shots} shots"),
        ("Temperature", at),
        ("Valid", f"until {report.valid_until}" if report.valid_until else "no certificate of an input limits it"),
    ]


def result_row(each: BudgetReport) -> tuple[str, str, str, str]:
    """Quantity, value and U to two digits of U, and k."""
    unit = definition_of(each.quantity).unit
    digits = max(0, 1 - math.floor(math.log10(each.U))) if each.U > 0.0 else 6
    value, expanded = (f"{number:.{digits}f} {unit}" for number in (each.value, each.U))
    return each.quantity, value, expanded, f"{each.k:.2f}"


def statement(report: CertificateReport) -> str:
    """What U means."""
    coverage = report.results[0].coverage if report.results else 0.95
    text = (
        f"U is the standard uncertainty times k, evaluated by JCGM 100:2008, so that value ± U covers the quantity "
        f"with a probability of about {coverage:.0%}, as far as its influences are declared."
    )
    if report.cone_rad is not None:
        text += f" The orientation of the rotor is known within a cone of {math.degrees(report.cone_rad):.2g}°."
    return text
