"""Certificates: valid by PTB's schema, the same in all forms, and refused where something undeclared dominates."""

import hashlib
import json
import math
from datetime import date, timedelta
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

import platform_daemon as pd_
from drivers.uncertainty import DeclaredUncertainty
from platform_daemon.core.schemas.fits import unfitted
from platform_daemon.core.settings import load_specimen
from platform_daemon.features.certificate.dcc import dcc_xml
from platform_daemon.features.certificate.page import certificate_page
from platform_daemon.features.certificate.pdf import certificate_pdf
from platform_daemon.features.certificate.schema import CertificateReport
from platform_daemon.features.certificate.words import result_row, result_rows, statement
from platform_daemon.features.certificate.work import certificate_of, misfit_of, read_details, refuse_dominated
from platform_daemon.features.fit.fit_request import FitSettings
from platform_daemon.features.fit.measurement import open_shots_for_fit
from platform_daemon.features.measurand.library import Measurands
from platform_daemon.features.measurand.work import calibrated
from platform_daemon.uncertainty.budget import Budget, NotDeclared
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.data import DATA
from tests.kit.pressure_sensor import PRESSURE, START_S, PressureSensor

DETAILS = """
number = "MMR-2026-0001"
person = "A. Metrologist"
laboratory = { name = "Laboratory", city = "Lübeck", country = "DE" }
customer = { name = "Customer", city = "Hamburg", country = "DE" }
"""
DCC = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}


class _Kept(etree.Resolver):
    """The schemas that are kept, whatever address they are imported by."""

    def resolve(self, url, public_id, context):
        return self.resolve_filename(str(DATA / "dcc" / url.rsplit("/", 1)[-1]), context)


@pytest.fixture(scope="module")
def schema():
    parser = etree.XMLParser()
    parser.resolvers.add(_Kept())
    return etree.XMLSchema(etree.parse(str(DATA / "dcc" / "dcc.xsd"), parser))


@pytest.fixture(scope="module")
def issued(measured, tmp_path_factory):
    folder = tmp_path_factory.mktemp("certificate")
    (folder / "details.toml").write_text(DETAILS)
    done = here("certificate", "jewel", measured / "j.h5", "--details", folder / "details.toml", "--out", folder / "c")
    assert done.returncode == 0, done.stderr
    assert "to be signed by A. Metrologist" in done.stdout
    return folder


def test_it_is_a_digital_calibration_certificate(issued, schema):
    document = etree.parse(str(issued / "c.xml"))
    assert schema.validate(document), schema.error_log
    report = json.loads((issued / "c.json").read_text())
    f_nat = report["results"][0]
    real = document.xpath("//dcc:result[dcc:name/dcc:content='f_nat_hz']//si:real", namespaces=DCC)[0]
    assert float(real.findtext("si:value", namespaces=DCC)) == pytest.approx(f_nat["value"], rel=1e-9)
    assert float(real.findtext("si:expandedUnc/si:uncertainty", namespaces=DCC)) == pytest.approx(f_nat["U"])
    assert real.findtext("si:unit", namespaces=DCC) == r"\hertz"
    # The schema is not one that takes everything.
    real.find("si:unit", namespaces=DCC).tag = "{https://ptb.de/si}units"
    assert not schema.validate(document)


def test_it_names_item_method_traceability_and_raw_data(issued, measured):
    report = json.loads((issued / "c.json").read_text())
    assert report["files"][0]["sha256"] == hashlib.sha256((measured / "j.h5").read_bytes()).hexdigest()
    assert [each["quantity"] for each in report["results"]] == [
        "f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2",
    ]  # fmt: skip
    assert {"temperature", "calibration", "sample clock"} <= {each["name"] for each in report["traceability"]}
    assert any("static field" in line for line in report["not_contained"])
    page = (issued / "c.html").read_text(encoding="utf-8")
    for said in ("MMR-2026-0001", "Lübeck", "Signature", report["files"][0]["sha256"]):
        assert said in page


@pytest.fixture(scope="module")
def sensor(issued, measured):
    """The jewel of the recording, calibrated as a sensor of pressure; and a certificate that says so."""
    shots, _ = PressureSensor(3).shots(START_S, 100, 900.0)
    reference = PressureSensor(3).reference(START_S, START_S + 90e3)
    folder = issued / "measurands"
    name = load_specimen("jewel")[0].name
    made = Measurands(folder).add(calibrated(name, PRESSURE, shots, reference, 1))
    silent = calibrated(name, PRESSURE.model_copy(update={"reference": None}), shots, reference, 1)
    Measurands(folder).add(silent)
    Measurands(folder).add(made.model_copy(update={"specimen": "another", "key": "another"}))
    asked = ("--details", issued / "details.toml", "--measurands", folder)

    def certificate(key, out):
        return here("certificate", "jewel", measured / "j.h5", *asked, "--measurand", key, "--out", issued / out)

    done = certificate(made.label, "sensor")
    assert done.returncode == 0, done.stderr
    return made, certificate, issued / "sensor"


def test_a_sensor_is_certified_with_its_range_and_the_u_of_one_shot(sensor, schema):
    made, _, files = sensor
    document = etree.parse(f"{files}.xml")
    assert schema.validate(document), schema.error_log
    part = json.loads(Path(f"{files}.json").read_text())["sensor"]
    assert (part["calibration"], part["unit"]) == (made.label, "mbar")
    values = [point["value"] for point in part["points"]]
    assert (values[0], values[-1]) == (pytest.approx(made.valid_from), pytest.approx(made.valid_to))
    first = "//dcc:result[dcc:name/dcc:content='pressure']//dcc:quantity[2]/si:realListXMLList"
    written = document.xpath(first, namespaces=DCC)[0]
    assert written.findtext("si:unitXMLList", namespaces=DCC) == r"\hecto\pascal"
    assert [float(x) for x in written.findtext("si:valueXMLList", namespaces=DCC).split()] == pytest.approx(values)
    expanded = written.findtext("si:expandedUncXMLList/si:uncertaintyXMLList", namespaces=DCC)
    assert [float(x) for x in expanded.split()] == pytest.approx([point["U"] for point in part["points"]])
    # U of one shot is that of a reading there: 20 mHz of scatter at 0.06 Hz/mbar, and 0.05 mbar of the barometer.
    middle = part["points"][2]
    slope = abs(np.gradient([point["f_nat_hz"] for point in part["points"]], values)[2])
    assert middle["U"] == pytest.approx(middle["k"] * math.hypot(made.scatter_hz / slope, 0.05), rel=0.1)
    for ending in ("html", "pdf"):
        assert Path(f"{files}.{ending}").stat().st_size > 1000
    page = Path(f"{files}.html").read_text(encoding="utf-8")
    assert "As a sensor of pressure" in page
    assert "certificate of the barometer" in page


def test_a_unit_that_the_certificate_has_no_word_for_is_written_as_text(sensor, schema):
    report = CertificateReport.model_validate_json(Path(f"{sensor[2]}.json").read_text())
    other = report.model_copy(update={"sensor": report.sensor.model_copy(update={"unit": "furlong"})})
    document = etree.fromstring(dcc_xml(other))
    assert schema.validate(document), schema.error_log
    assert "furlong, U = " in document.xpath("string(//dcc:noQuantity)", namespaces=DCC)


@pytest.mark.parametrize(
    ("key", "said"),
    [("another", "not of"), ("nothing", "no calibration"), ("{key}@2", "nobody has declared what the readings")],
)
def test_what_no_sensor_is_certified_by(sensor, key, said):
    made, certificate, _ = sensor
    assert_one_line_error(certificate(key.format(key=made.key), "refused"), 2, said)


def test_it_is_rounded_to_two_digits_of_u_and_has_units_and_words(issued):
    report = CertificateReport.model_validate_json((issued / "c.json").read_text())
    friction = report.results[3].model_copy(update={"value": 1379.4, "U": 191.3})
    assert result_row(friction)[1:3] == ("1380 rad/s^2", "190 rad/s^2")
    assert result_row(friction.model_copy(update={"value": 213.18642, "U": 0.09951}))[1:3] == (
        "213.19 rad/s^2",
        "0.10 rad/s^2",
    )
    assert result_rows(report)[0][0] == "natural frequency of small swings, f_nat"
    units = {line.name: line.unit for line in report.traceability}
    assert (units["temperature"], units["sample clock"], units["position along x"]) == ("K", "1", "m")
    page = (issued / "c.html").read_text(encoding="utf-8")
    for said in ("magnetic moment of the rotor, m_r", "0.1 K", "1.155e-05 (relative)"):
        assert said in page


def test_the_pdf_says_that_it_is_pdf_a(issued):
    content = (issued / "c.pdf").read_bytes()
    assert content.startswith(b"%PDF-1.7")
    assert b"<pdfaid:part>3</pdfaid:part>" in content
    assert b"<pdfaid:conformance>B</pdfaid:conformance>" in content
    assert b"/GTS_PDFA1" in content


def _with(missing):
    return Budget(
        quantity="f_nat_hz", value=213.0, u=0.02, dof=math.inf, k=1.96, coverage=0.95, contributions=(),
        not_declared=(missing,),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("missing", "refused"),
    [
        (NotDeclared("temperature, per 1 K", 0.23), True),
        (NotDeclared("static field, per 1 uT", 0.007), False),
        (NotDeclared("position, per 1 mm", math.nan), True),
        (NotDeclared("model (N50 and D30 agree)", 0.1, looked_for=True), False),
    ],
)
def test_what_nobody_has_declared_must_not_dominate(missing, refused):
    results = [_with(missing)]
    if not refused:
        refuse_dominated(results, "file")
        return
    with pytest.raises(pd_.InputError, match=r"no certificate: what nobody has declared dominates.*\[uncertainty\]"):
        refuse_dominated(results, "file")


@pytest.mark.parametrize(("chi2", "refused"), [((1.0, 1.1, 9.0), False), ((3.0, 49.0, 1.0), True)])
def test_a_model_that_does_not_describe_the_shots_is_signed_with_a_reason_only(chi2, refused, tmp_path):
    fits = [unfitted(k, "").model_copy(update={"verdict": "good", "chi2_per_dof": each}) for k, each in enumerate(chi2)]
    fits.append(unfitted(3, "no signal"))
    (tmp_path / "details.toml").write_text('accepted_misfit = "the pendulum\'s own mode, 2 % of F_m"\n' + DETAILS)
    accepting = read_details(tmp_path / "details.toml")
    strict = accepting.model_copy(update={"accepted_misfit": None})
    if not refused:
        assert misfit_of(fits, accepting, "file") is misfit_of(fits, strict, "file") is None
        return
    with pytest.raises(pd_.InputError, match=r"file: no certificate: the model does not.* 3 in .*accepted_misfit"):
        misfit_of(fits, strict, "file")
    told = misfit_of(fits, accepting, "file")
    assert "χ²/dof is 3 in the middle" in told
    assert told.endswith("accepted by A. Metrologist: the pendulum's own mode, 2 % of F_m")


@pytest.mark.parametrize("said", ["   ", "\u200b", "seen\u0007", "two\nlines"])
def test_a_reason_that_cannot_be_printed_is_none(said, tmp_path):
    (tmp_path / "details.toml").write_text(f"accepted_misfit = {json.dumps(said)}\n" + DETAILS)
    with pytest.raises(pd_.InputError, match=r"accepted_misfit.*words in one line that can be printed"):
        read_details(tmp_path / "details.toml")


def test_a_misfit_that_was_accepted_stands_in_the_statement_of_all_forms(issued, schema):
    report = CertificateReport.model_validate_json((issued / "c.json").read_bytes())
    told = report.model_copy(update={"accepted_misfit": "χ²/dof is 3; accepted by A. Metrologist: a test"})
    assert "does not contain the error of the model: χ²/dof is 3; accepted by A." in statement(told)
    document = dcc_xml(told)
    assert schema.validate(etree.fromstring(document))
    assert "accepted by A. Metrologist: a test" in document.decode()
    assert "accepted by A. Metrologist: a test" in certificate_page(told).decode()


def test_a_name_whose_signs_the_font_does_not_have_is_refused_and_not_left_out(issued):
    report = CertificateReport.model_validate_json((issued / "c.json").read_bytes())
    assert certificate_pdf(report.model_copy(update={"person": "Łukasz Жуков"}))
    with pytest.raises(pd_.InputError, match=r"its font has no sign for 字 漢.*Latin"):
        certificate_pdf(report.model_copy(update={"person": "漢字"}))


@pytest.mark.parametrize("of_sensor", [False, True])
def test_a_certificate_of_an_input_that_has_expired_since(sensor, issued, measured, of_sensor):
    """It was valid when the shots were made, and a certificate is issued a day too late."""
    measurement, ask = open_shots_for_fit(measured / "j.h5", FitSettings(None, "d30"))
    today = date.fromisoformat(measurement.recording.provenance.start_time[:10])
    paper = {"u": 1e-6, "certificate": {"number": "7", "date": date(2020, 1, 1), "valid_until": today}}
    reference = sensor[0].reference.model_copy(update={"valid_until": today.isoformat()})
    given = {"declared": None if of_sensor else DeclaredUncertainty.model_validate({"sample_clock": paper})}
    given["sensor"] = sensor[0].model_copy(update={"reference": reference}) if of_sensor else None
    who, own = read_details(issued / "details.toml"), load_specimen("jewel")[0]
    report = certificate_of(own, measurement, ask, who, issued=today, **given)
    assert report.valid_until == today.isoformat()
    with pytest.raises(pd_.InputError, match=rf"not be valid any more.*expired on {today}.*record again"):
        certificate_of(own, measurement, ask, who, issued=today + timedelta(days=1), **given)


def test_what_is_refused(measured, tmp_path):
    details = tmp_path / "details.toml"
    details.write_text(DETAILS)
    asked = ("--details", details, "--out", tmp_path / "c")
    assert_one_line_error(here("certificate", "thread", measured / "j.h5", *asked), 2, "not of")
    details.write_text(DETAILS.replace('"DE"', '"Germany"', 1))
    assert_one_line_error(here("certificate", "jewel", measured / "j.h5", *asked), 2, "laboratory.country")
    assert list(Path(tmp_path).iterdir()) == [details]
