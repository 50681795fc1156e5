"""The picture of docs/howto/reproduce.md: why the two windows disagree, and by how much before and after a diagnosis.

From the files that `platform-daemon diagnose --json` wrote of a thread and of a jewel:
python -m tests.campaigns.paper_loop_picture thread.json jewel.json --png docs/pictures/two-windows.png
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

_SIGNIFICANT = 3.29  # the paper's alpha of 0.001
_NAMES = {
    "f_nat_hz": ("$f_{nat}$", "Hz", 1.0),
    "m_r_am2": ("$m_r$", "mA m²", 1e3),
    "lambda_per_s": ("λ", "1/s", 1.0),
    "tf_over_i_rad_per_s2": ("$T_f/I$", "rad/s²", 1.0),
    "phi_max_rad": ("$φ_{max}$", "°", math.degrees(1.0)),
    "psi_start_rad": ("$ψ_{start}$", "°", math.degrees(1.0)),
}


def draw(reports: list[dict[str, Any]], titles: list[str], path: Path) -> None:
    """One column for each report: what moves along the ring-down, and the disagreement before and after."""
    figure, axes = plt.subplots(2, len(reports), figsize=(9.0, 6.0), layout="constrained", squeeze=False)
    for column, (report, title) in enumerate(zip(reports, titles, strict=True)):
        axes[0, column].set_title(title)
        _along(axes[0, column], report["where"])
        _windows(axes[1, column], report["n50_d30"])
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _along(axes: Axes, where: list[dict[str, Any]]) -> None:
    """The parameter that would have to move, fitted piece by piece, in each shot."""
    first = next((w for w in where if w["traces"]), None)
    if first is None:
        axes.set_axis_off()
        return
    name, unit, factor = _NAMES.get(first["name"], (first["name"], "", 1.0))
    for trace in first["traces"]:
        values, stds = ([factor * v for v in trace[key]] for key in ("value", "std"))
        axes.errorbar(trace["time_s"], values, stds, marker=".", markersize=4, linewidth=1.0)
    axes.set_xlabel("time after the first RX sample / s")
    axes.set_ylabel(f"{name} / {unit}")


def _windows(axes: Axes, disagreement: dict[str, dict[str, float | None]]) -> None:
    """|N50 - D30| in standard errors, before and after."""
    names = [n for n in _NAMES if n in disagreement]
    for offset, key, label in ((-0.2, "before_sigma", "declared model"), (0.2, "after_sigma", "after the diagnosis")):
        found = [(k + offset, disagreement[n][key]) for k, n in enumerate(names)]
        shown = [(at, max(value, 0.05)) for at, value in found if value is not None]
        axes.bar([at for at, _ in shown], [value for _, value in shown], 0.38, label=label)
    axes.axhline(_SIGNIFICANT, color="black", linestyle="--", linewidth=1.0)
    axes.set_yscale("log")
    axes.set_xticks(range(len(names)), [_NAMES[n][0] for n in names])
    axes.set_ylabel("|N50 − D30| / standard error")
    axes.legend(fontsize="small")


def main() -> None:
    """Draw the two reports."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("thread", type=Path)
    parser.add_argument("jewel", type=Path)
    parser.add_argument("--png", type=Path, required=True)
    args = parser.parse_args()
    reports = [json.loads(path.read_text()) for path in (args.thread, args.jewel)]
    draw(reports, ["Thread", "Jewel"], args.png)


if __name__ == "__main__":
    main()
