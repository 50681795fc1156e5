"""Certificates: valid by PTB's schema, the same in all forms, and refused where something undeclared dominates."""

import hashlib
import json
import math
from pathlib import Path

import pytest
from lxml import etree

import platform_daemon as pd_
from platform_daemon.features.certificate.work import refuse_dominated
from platform_daemon.uncertainty.budget import Budget, NotDeclared
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.data import DATA

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
def issued(measured):
    folder = measured / "certificate"
    folder.mkdir()
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


def test_what_is_refused(measured, tmp_path):
    details = tmp_path / "details.toml"
    details.write_text(DETAILS)
    asked = ("--details", details, "--out", tmp_path / "c")
    assert_one_line_error(here("certificate", "thread", measured / "j.h5", *asked), 2, "not of")
    details.write_text(DETAILS.replace('"DE"', '"Germany"', 1))
    assert_one_line_error(here("certificate", "jewel", measured / "j.h5", *asked), 2, "laboratory.country")
    assert list(Path(tmp_path).iterdir()) == [details]
