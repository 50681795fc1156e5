"""The paper's tables with every specimen in each, and how a table is written in LaTeX."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from platform_daemon.features.characterise.report import WordedTable, characterisation_tables
from platform_daemon.features.characterise.schema import CharacterisationReport

_NAMES = (
    "measurement_parameter",
    "fit_results_quality",
    "model_params_fit_result",
    "n50_against_d30",
    "uncertainties",
    "mean_uncertainties",
    "quality_factors",
)
_LATEX = {
    "\\": r"\textbackslash{}", "_": r"\_", "%": r"\%", "&": r"\&", "#": r"\#", "$": r"\$", "{": r"\{", "}": r"\}",
    "±": r"$\pm$", "−": "$-$", "µ": r"\textmu{}", "°": r"$^\circ$", "χ": r"$\chi$", "λ": r"$\lambda$",
    "φ": r"$\varphi$", "ψ": r"$\psi$", "α": r"$\alpha$", "²": "$^2$", "⁻": "$^-$", "¹": "$^1$", "|": r"\textbar{}",
}  # fmt: skip


@dataclass(frozen=True)
class NamedTable:
    """A table, and the name of its files without ending, which is that of the paper's label behind `tab:`."""

    name: str
    table: WordedTable


def tables_of(reports: Mapping[str, CharacterisationReport]) -> Iterator[NamedTable]:
    """A row for each specimen and window; none without a report."""
    made = {variant: characterisation_tables(report) for variant, report in reports.items()}
    for k, name in enumerate(_NAMES):
        parts = [(variant, tables[k]) for variant, tables in made.items()]
        if parts:
            yield NamedTable(name, _joined(parts))


def _joined(parts: Sequence[tuple[str, WordedTable]]) -> WordedTable:
    """Below each other; a cell is "-" where a specimen has no such column."""
    headings = list(dict.fromkeys(heading for _, table in parts for heading, _ in table.columns))
    first = parts[0][1]
    index = [variant for variant, table in parts for _ in table.index[1]]
    columns = [(first.index[0], [cell for _, table in parts for cell in table.index[1]])]
    for heading in headings:
        cells = [cell for _, table in parts for cell in dict(table.columns).get(heading, ["-"] * len(table.index[1]))]
        columns.append((heading, cells))
    return WordedTable(first.title, ("specimen", index), tuple(columns), first.said)


def headings_of(table: WordedTable) -> tuple[str, ...]:
    """Of all columns, the first one too."""
    return (table.index[0], *(heading for heading, _ in table.columns))


def table_latex(table: WordedTable) -> str:
    """A tabular."""
    headings = headings_of(table)
    lines = [row_latex(headings) + r" \hline", *(row_latex(cells) for cells in table.rows())]
    return "\n".join([rf"\begin{{tabular}}{{l{'r' * (len(headings) - 1)}}}", *lines, r"\end{tabular}", ""])


def row_latex(cells: Iterable[str]) -> str:
    """A row, what LaTeX would take for a command as text."""
    return " & ".join("".join(_LATEX.get(c, c) for c in cell) for cell in cells) + r" \\"
