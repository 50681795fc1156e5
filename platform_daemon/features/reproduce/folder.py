"""What a campaign's folder holds beside its recordings: the claims, one page, one PDF, figures and tables."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.output import write_json
from platform_daemon.core.state.durable import write_file
from platform_daemon.features.characterise.report import WordedTable
from platform_daemon.features.characterise.schema import CharacterisationReport
from platform_daemon.features.characterise.side_by_side.figures import measured_figures
from platform_daemon.features.characterise.side_by_side.folder import SideBySide, write_folder
from platform_daemon.features.characterise.side_by_side.noise_schema import NoiseSweepReport
from platform_daemon.features.characterise.side_by_side.tables import tables_of
from platform_daemon.features.characterise.tables import CharacterisationTask

from .claims import contradictions
from .figures import design_figures
from .report import claim_cells, claim_rows, claims_latex, count_text
from .schema import Claims

_TITLE = "The paper's numbers by one command"
_HEADINGS = ("what", "paper", "ours", "tolerance", "verdict")
_WIDTHS = (16, 16, 7, 7, 8, 9, 5, 12, 20)  # label and these, u, command, why


def write_claims(
    folder: Path,
    claims: Claims,
    tasks: Mapping[str, CharacterisationTask],
    reports: Mapping[str, CharacterisationReport],
    noise: NoiseSweepReport | None,
) -> None:
    """Write all of it; what was there before is replaced.

    Raises StorageError; PlatformError for a recording that can no longer be read.
    """
    write_json(folder / "claims.json", claims)
    write_csv(folder / "claims.csv", claim_rows(claims))
    write_file(folder / "claims.tex", claims_latex(claims).encode())
    said = [f"The paper disagrees with itself: {text}." for text in contradictions()]
    told = SideBySide(
        title=_TITLE,
        said=[f"{count_text(claims)}.", *said],
        tables=list(tables_of(reports)),
        figures=[*design_figures(), *measured_figures(reports, tasks, noise)],
        first=_table(claims, with_why=True),
        first_widths=_WIDTHS,
        first_printed=_table(claims, with_why=False),
    )
    write_folder(folder, told)


def _table(claims: Claims, *, with_why: bool) -> WordedTable:
    """with_why: also `u`, the command and the reason."""
    cells = [claim_cells(claim) for claim in claims.claims]
    columns = [(heading, [row[k] for row in cells]) for k, heading in enumerate(_HEADINGS)]
    if with_why:
        columns.append(("u", ["-" if claim.u is None else f"{claim.u:.2g}" for claim in claims.claims]))
        columns.append(("command", [claim.command for claim in claims.claims]))
        columns.append(("why", [claim.why for claim in claims.claims]))
    return WordedTable("Claims", ("label", [claim.label for claim in claims.claims]), tuple(columns))
