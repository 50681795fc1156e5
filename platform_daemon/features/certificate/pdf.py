"""A certificate as PDF/A-3b, by fpdf2, which embeds fonts and colour profile and refuses what the standard forbids."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

import matplotlib
from fpdf import FPDF
from fpdf.enums import DocumentCompliance
from fpdf.fonts import TTFFont

from drivers.errors import InputError

from .schema import CertificateReport
from .words import TITLE, facts, known_with, result_rows, sensor_rows, sensor_statement, statement

_FONT = "DejaVu"
_LINE_MM, _SIZE = 5.5, 9.0


class _Document(FPDF):
    """A PDF/A whose pages each say of which certificate they are, and the how manieth of how many (ISO/IEC 17025,
    7.8.2.1)."""

    def __init__(self, name: str) -> None:
        super().__init__(format="A4", enforce_compliance=DocumentCompliance.PDFA_3B)
        self._name = name

    def footer(self) -> None:
        """At the foot of each page; fpdf2 calls it."""
        self.set_y(-15)
        self.set_font(_FONT, "", 8)
        self.cell(0, 8, f"{self._name}, page {self.page_no()} of {{nb}}", align="C")


def certificate_pdf(report: CertificateReport) -> bytes:
    """The document; the same report gives the same bytes.  Raises InputError for signs that its font does not have."""
    pdf = _Document(f"{TITLE} {report.number}")
    pdf.set_creation_date(datetime.fromisoformat(f"{report.issued}T00:00:00+00:00"))
    pdf.set_title(f"{TITLE} {report.number}")
    pdf.set_lang("en")
    fonts = Path(matplotlib.get_data_path(), "fonts", "ttf")
    pdf.add_font(_FONT, "", fonts / "DejaVuSans.ttf")
    pdf.add_font(_FONT, "B", fonts / "DejaVuSans-Bold.ttf")
    _refuse_missing_signs(pdf, report)
    pdf.set_auto_page_break(True, 20)
    pdf.add_page()
    pdf.set_font(_FONT, "B", 15)
    pdf.cell(0, 12, TITLE, new_x="LMARGIN", new_y="NEXT")
    for name, value in facts(report):
        _pair(pdf, name, value)
    _heading(pdf, "Results")
    _table(pdf, [("quantity", "value", "U", "k"), *result_rows(report)], (50, 22, 22, 6))
    _paragraph(pdf, statement(report))
    if report.sensor is not None:
        _heading(pdf, f"As a sensor of {report.sensor.name}")
        _table(pdf, sensor_rows(report.sensor))
        _paragraph(pdf, sensor_statement(report.sensor))
    _list(pdf, "Method", report.method)
    _list(pdf, "Traceability", [f"{each.name}: u = {known_with(each)}; {each.source}" for each in report.traceability])
    _list(pdf, "Not contained in U", report.not_contained or ("nothing that is known of",))
    _list(pdf, "Raw data", [f"{each.file}, SHA-256 {each.sha256}" for each in report.files])
    _heading(pdf, "Signature")
    pdf.ln(14)
    _paragraph(pdf, f"{report.person}, {report.laboratory.name}                    Date:")
    return bytes(pdf.output())


def _refuse_missing_signs(pdf: FPDF, report: CertificateReport) -> None:
    """They would be left out of what is signed."""
    font = pdf.fonts[_FONT.lower()]
    assert isinstance(font, TTFFont)
    missing = sorted({sign for sign in report.model_dump_json() if ord(sign) not in font.cmap and sign.isprintable()})
    if missing:
        what, why = "the certificate cannot be printed", f"its font has no sign for {' '.join(missing)}"
        remedy = "write names and reasons in Latin, Greek or Cyrillic letters"
        raise InputError(what, where=report.number, why=why, remedy=remedy)


def _table(pdf: FPDF, rows: Sequence[Sequence[str]], widths: tuple[int, ...] | None = None) -> None:
    """The first row is the heading; widths: of the columns, in parts of the whole, None: all alike."""
    pdf.set_font(_FONT, "", _SIZE)
    with pdf.table(first_row_as_headings=True, line_height=_LINE_MM, col_widths=widths) as table:
        for cells in rows:
            row = table.row()
            for cell in cells:
                row.cell(cell)


def _heading(pdf: FPDF, text: str) -> None:
    pdf.ln(2)
    pdf.set_font(_FONT, "B", 11)
    pdf.cell(0, 8, text, new_x="LMARGIN", new_y="NEXT")


def _pair(pdf: FPDF, name: str, value: str) -> None:
    pdf.set_font(_FONT, "B", _SIZE)
    pdf.cell(32, _LINE_MM, name)
    pdf.set_font(_FONT, "", _SIZE)
    pdf.multi_cell(0, _LINE_MM, value, new_x="LMARGIN", new_y="NEXT")


def _paragraph(pdf: FPDF, text: str) -> None:
    pdf.set_font(_FONT, "", _SIZE)
    pdf.multi_cell(0, _LINE_MM, text, new_x="LMARGIN", new_y="NEXT")


def _list(pdf: FPDF, heading: str, lines: tuple[str, ...] | list[str]) -> None:
    _heading(pdf, heading)
    for line in lines:
        _paragraph(pdf, line)
