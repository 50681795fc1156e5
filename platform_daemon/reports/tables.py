"""Tables for the terminal."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from platform_daemon.schemas import DeviceReport

MOMENT = "m_r_am2"
Column = tuple[str, str, float]
COLUMNS: tuple[Column, ...] = (  # parameter, heading, factor from SI to the unit shown
    ("f_nat_hz", "f_nat / Hz", 1.0),
    (MOMENT, "m_r / mAm²", 1e3),
    ("lambda_per_s", "λ / s⁻¹", 1.0),
    ("tf_over_i_rad_per_s2", "T_f/I / rad s⁻²", 1.0),
    ("phi_max_rad", "φ_max / °", math.degrees(1)),
    ("psi_start_rad", "ψ_start / °", math.degrees(1)),
)


def number(value: float | None, std: float | None, factor: float) -> str:
    """Value with its standard deviation in brackets at the last digits: 215.6903(12); plain if there is none."""
    if value is None:
        return "-"
    if std is None or not std > 0:
        return f"{value * factor:.6g}"
    digits = max(0, 1 - math.floor(math.log10(std * factor)))
    return f"{value * factor:.{digits}f}({round(std * factor * 10**digits)})"


def fit_table_text(report: Mapping[str, Any]) -> str:
    """One file's fits as a table: a row per frame, then mean and scatter."""
    title = f"{report['file']}  {report['variant']}, window {report['window']}"
    table = Table(title=title, title_justify="left")
    summary = report["summary"]
    columns = _columns(summary)
    for heading in ("frame", *(c[1] for c in columns), "R² / %", "nRMSE / %", "χ²/dof"):
        table.add_column(heading, justify="right")
    for frame in report["frames"]:
        table.add_row(*_row(frame, columns))
    if any(s["std"] is not None for s in summary.values()):
        table.add_section()
        cells = [number(s["mean"], s["std"], c[2]) if (s := summary.get(c[0])) else "-" for c in columns]
        table.add_row("mean(scatter)", *cells, "", "", "")
    console = Console(width=150)
    with console.capture() as capture:
        console.print(table)
        for note in _notes(report):
            console.print(note, highlight=False, markup=False)  # [frame 1] is no mark-up
    return capture.get().rstrip()


def _columns(found: Collection[str]) -> tuple[Column, ...]:
    """Columns of what was fitted; coefficients of further terms by their names, which hold their units."""
    if not found:
        return COLUMNS
    others = [n for n in found if n not in {c[0] for c in COLUMNS} and not n.startswith("rodrigues")]
    return (*(c for c in COLUMNS if c[0] in found), *((name, name, 1.0) for name in others))


def fit_line(report: Mapping[str, Any]) -> str:
    """One file's fits in one line: how many, and the mean with the scatter of the parameters."""
    good = sum(frame["verdict"] == "good" for frame in report["frames"])
    parts = [f"{good} of {len(report['frames'])} frames good"]
    for name, heading, factor in COLUMNS[:4]:
        if name in report["summary"]:
            symbol, _, unit = heading.partition(" / ")
            found = report["summary"][name]
            parts.append(f"{symbol} {number(found['mean'], found['std'], factor)} {unit}")
    return ", ".join(parts)


def _row(frame: Mapping[str, Any], columns: Sequence[Column]) -> list[str]:
    p = frame["parameters"]
    if frame["verdict"] != "good":
        return [str(frame["frame"]), "refused", *[""] * (len(columns) - 1 + 3)]
    cells = [number(p[c[0]]["value"], p[c[0]]["std"], c[2]) if c[0] in p else "-" for c in columns]
    quality = (f"{100 * frame['r2']:.4f}", f"{100 * frame['nrmse']:.3f}", f"{frame['chi2_per_dof']:.3f}")
    return [str(frame["frame"]), *cells, *quality]


def _notes(report: Mapping[str, Any]) -> list[str]:
    """Notes of the file and of its frames, each text once with the frames it holds for."""
    said: dict[str, list[int]] = {}
    for frame in report["frames"]:
        texts = [*frame["notes"], *frame["warnings"]]
        for text in [*texts, f"refused: {frame['reason']}"] if frame["verdict"] != "good" else texts:
            said.setdefault(text, []).append(frame["frame"])
    noise = report["noise"]
    lines = [f"note: {n}" for n in report["notes"]]
    if MOMENT in report["systematic_std"]:
        std = 1e3 * report["systematic_std"][MOMENT]
        lines.append(f"m_r has a systematic standard uncertainty of {std:.2g} mAm² besides, from the calibration")
    if noise["source"] is not None:
        lines.append(f"noise from {noise['source']}, found in {noise['seconds']:.3f} s beside the fits")
    for text, frames in said.items():
        shown = ", ".join(map(str, frames[:6])) + (" ..." if len(frames) > 6 else "")
        lines.append(f"frame {shown}: {text}")
    return lines


def print_info(facts: Mapping[str, Any], indent: str = "") -> None:
    """Nested facts, one per line."""
    for key, value in facts.items():
        if isinstance(value, Mapping):
            print(f"{indent}{key}:")
            print_info(value, indent + "  ")
        elif isinstance(value, list) and value and isinstance(value[0], Mapping):
            print(f"{indent}{key}:")
            for k, item in enumerate(value):
                print(
                    f"{indent}  [{k}] "
                    + ", ".join(f"{a}={b}" for a, b in item.items() if b not in (None, "", [], False))
                )
        else:
            print(f"{indent}{key}: {value}")


def print_devices(reports: Sequence[DeviceReport]) -> None:
    """A row per device: who it is, its state, and what went wrong."""
    table = Table()
    for heading in ("device", "identity", "state", "error"):
        table.add_column(heading, overflow="fold")
    for report in reports:
        identity = " ".join(part for _, part in report.identity or () if part)
        state = ", ".join(f"{name} {_plain(value)}" for name, value in report.state)
        table.add_row(report.device, identity or "-", state or "-", report.error or "-")
    Console().print(table)


def _plain(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
