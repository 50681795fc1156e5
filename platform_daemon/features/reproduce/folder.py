"""What a campaign's folder holds beside its recordings: one page, one PDF, figures, tables, and the claims."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.output import write_json
from platform_daemon.core.reporting.figures import vector_of
from platform_daemon.core.reporting.page import page
from platform_daemon.core.state.durable import write_file
from platform_daemon.features.characterise.report import WordedTable
from platform_daemon.features.characterise.schema import CharacterisationReport

from .claims import contradictions
from .document import pdf_of
from .figures import figures_of
from .report import claim_cells, claim_rows, claims_latex, count_text
from .schema import Claims
from .tables import headings_of, table_latex, tables_of


def write_folder(folder: Path, claims: Claims, reports: Mapping[str, CharacterisationReport]) -> None:
    """Write all of it; what was there before is replaced.

    Raises StorageError; PlatformError for a recording that can no longer be read.
    """
    write_json(folder / "claims.json", claims)
    write_csv(folder / "claims.csv", claim_rows(claims))
    write_file(folder / "claims.tex", claims_latex(claims).encode())
    for name in ("tables", "figures"):
        (folder / name).mkdir(exist_ok=True)
    tables = list(tables_of(reports))
    for name, table in tables:
        rows = (dict(zip(headings_of(table), cells, strict=True)) for cells in table.rows())
        write_csv(folder / "tables" / f"{name}.csv", rows)
        write_file(folder / "tables" / f"{name}.tex", table_latex(table).encode())
    figures = list(figures_of(reports, folder))
    for name, _, figure in figures:
        write_file(folder / "figures" / f"{name}.svg", vector_of(figure, "svg"))
        write_file(folder / "figures" / f"{name}.pdf", vector_of(figure, "pdf"))
    write_file(folder / "report.html", _html(claims, tables, figures))
    write_file(folder / "report.pdf", pdf_of(claims, tables, figures))  # last: it puts captions over the figures


def _html(
    claims: Claims, tables: Sequence[tuple[str, WordedTable]], figures: Sequence[tuple[str, str, Figure]]
) -> bytes:
    rows = []
    for claim in claims.claims:
        what, paper, ours, tolerance, verdict = claim_cells(claim)
        u = "-" if claim.u is None else f"{claim.u:.2g}"
        rows.append((claim.label, what, paper, ours, u, tolerance, verdict, claim.command, claim.why))
    return page(
        "reproduction_page.html",
        {},
        count=count_text(claims),
        contradictions=contradictions(),
        claims=rows,
        tables=tables,
        headings_of=headings_of,
        figures=figures,
    )
