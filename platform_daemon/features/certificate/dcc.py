"""A certificate as Digital Calibration Certificate: XML by PTB's schema dcc.xsd 3.2.1 with units of D-SI."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from xml.etree import ElementTree

from platform_daemon import __version__
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.features.budget.schema import BudgetReport

from .schema import CertificateContact, CertificateReport, SensorPart
from .words import TITLE, known_with, sensor_statement, statement

VERSION = "3.2.1"
DCC, SI = "https://ptb.de/dcc", "https://ptb.de/si"
_UNITS = {
    "Hz": r"\hertz",
    "A m^2": r"\ampere\metre\tothe{2}",
    "1/s": r"\second\tothe{-1}",
    "rad/s^2": r"\radian\second\tothe{-2}",
}
_UNITS_OF_MEASURANDS = {
    "Pa": r"\pascal",
    "hPa": r"\hecto\pascal",
    "mbar": r"\hecto\pascal",  # the same size, by its name in the SI
    "kPa": r"\kilo\pascal",
    "degC": r"\degreecelsius",
    "°C": r"\degreecelsius",
    "K": r"\kelvin",
    "m": r"\metre",
    "mm": r"\milli\metre",
    "um": r"\micro\metre",
    "T": r"\tesla",
    "mT": r"\milli\tesla",
    "uT": r"\micro\tesla",
    "N": r"\newton",
    "mN": r"\milli\newton",
}
"""Units that a measurand may have, in words of D-SI; a quantity in another one is written as text."""
Element = ElementTree.Element


def dcc_xml(report: CertificateReport) -> bytes:
    """The document in UTF-8."""
    ElementTree.register_namespace("dcc", DCC)
    ElementTree.register_namespace("si", SI)
    root = Element(f"{{{DCC}}}digitalCalibrationCertificate", {"schemaVersion": VERSION})
    _administrative(_add(root, "administrativeData"), report)
    _result(_add(_add(root, "measurementResults"), "measurementResult"), report)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))


def _administrative(to: Element, report: CertificateReport) -> None:
    software = _add(_add(to, "dccSoftware"), "software")
    _text(software, "name", "platform-daemon")
    _add(software, "release", __version__)
    core = _add(to, "coreData")
    _add(core, "countryCodeISO3166_1", report.laboratory.country)
    _add(core, "usedLangCodeISO639_1", "en")
    _add(core, "mandatoryLangCodeISO639_1", "en")
    _add(core, "uniqueIdentifier", report.number)
    _add(core, "beginPerformanceDate", report.measured_from)
    _add(core, "endPerformanceDate", report.measured_to)
    _add(core, "performanceLocation", "laboratory")
    _add(core, "issueDate", report.issued)
    item = _add(_add(to, "items"), "item")
    _text(item, "name", f"magneto-mechanical resonator, {report.variant} bearing")
    names = _add(item, "identifications")
    for value in filter(None, (report.item, report.sample)):
        each = _add(names, "identification")
        _add(each, "issuer", "calibrationLaboratory")
        _add(each, "value", value)
    _contact(_add(_add(to, "calibrationLaboratory"), "contact"), report.laboratory)
    person = _add(_add(to, "respPersons"), "respPerson")
    _text(_add(person, "person"), "name", report.person)
    _add(person, "mainSigner", "true")
    _contact(_add(to, "customer"), report.customer)
    statements = _add(to, "statements")
    each = _add(statements, "statement")
    _text(each, "name", "uncertainty")
    _text(each, "declaration", statement(report))
    for line in report.not_contained:
        each = _add(statements, "statement")
        _text(each, "name", "not contained in U")
        _text(each, "declaration", line)


def _result(to: Element, report: CertificateReport) -> None:
    _text(to, "name", TITLE)
    methods = _add(to, "usedMethods")
    for line in report.method:
        _text(_add(methods, "usedMethod"), "name", line)
    if report.traceability:
        equipment = _add(to, "measuringEquipments")
        for known in report.traceability:
            each = _add(equipment, "measuringEquipment")
            _text(each, "name", known.name)
            _text(each, "description", f"u = {known_with(known)}; {known.source}")
    if report.temperature_c is not None:
        condition = _add(_add(to, "influenceConditions"), "influenceCondition")
        _text(condition, "name", "temperature")
        _real(_add(_add(condition, "data"), "quantity"), report.temperature_c, r"\degreecelsius")
    results = _add(to, "results")
    for budget in report.results:
        each = _add(results, "result")
        _text(each, "name", budget.quantity)
        _budget(_add(_add(each, "data"), "quantity"), budget)
    if report.sensor is not None:
        _sensor(_add(results, "result"), report.sensor)
    for file in report.files:
        each = _add(results, "result")
        _text(each, "name", f"raw data {file.file}")
        _text(_add(each, "data"), "text", f"SHA-256 {file.sha256}, {file.size_bytes} bytes")


def _sensor(to: Element, sensor: SensorPart) -> None:
    """A list of two quantities of one length: the frequency, and the measurand with U of one shot."""
    _text(to, "name", sensor.name)
    data = _add(to, "data")
    _text(data, "text", sensor_statement(sensor))
    both = _add(data, "list")
    frequency = _add(both, "quantity")
    _text(frequency, "name", "f_nat_hz")
    _real_list(frequency, [point.f_nat_hz for point in sensor.points], _UNITS["Hz"])
    measurand = _add(both, "quantity")
    _text(measurand, "name", sensor.name)
    unit = _UNITS_OF_MEASURANDS.get(sensor.unit)
    if unit is None:
        lines = (f"{p.value:.10g} {sensor.unit}, U = {p.U:.3g} {sensor.unit} (k = {p.k:.2f})" for p in sensor.points)
        _text(measurand, "noQuantity", "; ".join(lines))
        return
    values = _real_list(measurand, [point.value for point in sensor.points], unit)
    expanded = ElementTree.SubElement(values, f"{{{SI}}}expandedUncXMLList")
    _si(expanded, "uncertaintyXMLList", _decimals([point.U for point in sensor.points]))
    _si(expanded, "coverageFactorXMLList", _decimals([point.k for point in sensor.points]))
    _si(expanded, "coverageProbabilityXMLList", _decimal(sensor.coverage))


def _real_list(to: Element, values: Sequence[float], unit: str) -> Element:
    found = ElementTree.SubElement(to, f"{{{SI}}}realListXMLList")
    _si(found, "valueXMLList", _decimals(values))
    _si(found, "unitXMLList", unit)
    return found


def _decimals(values: Sequence[float]) -> str:
    return " ".join(map(_decimal, values))


def _budget(to: Element, budget: BudgetReport) -> None:
    real = _real(to, budget.value, _UNITS[definition_of(budget.quantity).unit])
    expanded = ElementTree.SubElement(real, f"{{{SI}}}expandedUnc")
    _si(expanded, "uncertainty", _decimal(budget.U))
    _si(expanded, "coverageFactor", _decimal(budget.k))
    _si(expanded, "coverageProbability", _decimal(budget.coverage))
    _si(expanded, "distribution", "normal" if budget.dof is None else "t")


def _real(to: Element, value: float, unit: str) -> Element:
    real = ElementTree.SubElement(to, f"{{{SI}}}real")
    _si(real, "value", _decimal(value))
    _si(real, "unit", unit)
    return real


def _contact(to: Element, contact: CertificateContact) -> None:
    _text(to, "name", contact.name)
    place = _add(to, "location")
    _add(place, "city", contact.city)
    _add(place, "countryCode", contact.country)


def _decimal(value: float) -> str:
    """Ten digits, without the exponent's plus sign, which the schema does not know."""
    assert math.isfinite(value)
    return f"{Decimal(f'{value:.10g}'):f}"


def _add(to: Element, name: str, text: str | None = None) -> Element:
    made = ElementTree.SubElement(to, f"{{{DCC}}}{name}")
    made.text = text
    return made


def _si(to: Element, name: str, text: str) -> None:
    ElementTree.SubElement(to, f"{{{SI}}}{name}").text = text


def _text(to: Element, name: str, text: str) -> None:
    content = _add(_add(to, name), "content", text)
    content.set("lang", "en")
