"""A certificate in words: the same for page and PDF."""

from __future__ import annotations

import math

from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.features.budget.schema import BudgetReport

from .schema import CertificateReport, SensorPart, TraceabilityLine

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
    digits = 1 - math.floor(math.log10(float(f"{each.U:.1e}"))) if each.U > 0.0 else 6
    value, expanded = (f"{round(number, digits) + 0.0:.{max(0, digits)}f} {unit}" for number in (each.value, each.U))
    return each.quantity, value, expanded, f"{each.k:.2f}"


def result_rows(report: CertificateReport) -> list[tuple[str, str, str, str]]:
    """The same of all results, with the quantity in words."""
    return [(_in_words(each.quantity), *result_row(each)[1:]) for each in report.results]


def _in_words(quantity: str) -> str:
    known = definition_of(quantity)
    return f"{known.description.partition(' (eq:')[0]}, {known.symbol}"


def known_with(line: TraceabilityLine) -> str:
    """The standard uncertainty of an input, with its unit."""
    return f"{line.u:.4g} {'(relative)' if line.unit == '1' else line.unit}"


def statement(report: CertificateReport) -> str:
    """What U means."""
    coverage = report.results[0].coverage if report.results else 0.95
    text = (
        f"U is the standard uncertainty times k, evaluated by JCGM 100:2008, so that value ± U covers the quantity "
        f"with a probability of about {coverage:.0%}, as far as its influences are declared."
    )
    if report.accepted_misfit is not None:
        text += f" U does not contain the error of the model: {report.accepted_misfit}."
    if report.cone_rad is not None:
        known = f"known within a cone of {math.degrees(report.cone_rad):.2g}°"
        text += f" The orientation of the rotor is {known if report.cone_rad < math.pi else 'not known'}."
    return text


def sensor_rows(sensor: SensorPart) -> list[tuple[str, str, str, str]]:
    """Heading, and a line for each place of the range: quantity, frequency, U of one shot, and k."""
    heading = (f"{sensor.name} / {sensor.unit}", "f_nat / Hz", f"U of one shot / {sensor.unit}", "k")
    lines = [(f"{p.value:.6g}", f"{p.f_nat_hz:.4f}", f"{p.U:.2g}", f"{p.k:.2f}") for p in sensor.points]
    return [heading, *lines]


def sensor_statement(sensor: SensorPart) -> str:
    """What the calibration holds for."""
    low, high = sensor.points[0].value, sensor.points[-1].value
    text = (
        f"As a sensor of {sensor.name} by the calibration {sensor.calibration} of {sensor.calibrated_from[:10]} to "
        f"{sensor.calibrated_to[:10]}, the resonator holds from {low:.6g} to {high:.6g} {sensor.unit}"
    )
    if sensor.temperature_from_c is not None and sensor.temperature_to_c is not None:
        text += f" and from {sensor.temperature_from_c:.2f} to {sensor.temperature_to_c:.2f} °C"
    if sensor.temperature_c is not None:
        text += f"; the frequencies are those at {sensor.temperature_c:.2f} °C"
    return " ".join((f"{text}.", *(f"{note[0].upper()}{note[1:]}." for note in sensor.notes)))
