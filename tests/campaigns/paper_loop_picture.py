"""The picture of docs/howto/reproduce.md: by how much the two windows disagree before and after a diagnosis.

From the files that `platform-daemon diagnose --json` wrote of a thread and of a jewel:
python -m tests.campaigns.paper_loop_picture thread.json jewel.json --png docs/pictures/two-windows.png
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

_SIGNIFICANT = 3.29  # the paper's alpha of 0.001
_NAMES = {
    "f_nat_hz": "$f_{nat}$",
    "m_r_am2": "$m_r$",
    "lambda_per_s": "λ",
    "tf_over_i_rad_per_s2": "$T_f/I$",
    "phi_max_rad": "$φ_{max}$",
    "psi_start_rad": "$ψ_{start}$",
}


def draw(reports: list[dict[str, Any]], titles: list[str], path: Path) -> None:
    """One column for each report."""
    figure, axes = plt.subplots(1, len(reports), figsize=(9.0, 3.6), layout="constrained", sharey=True)
    for each, report, title in zip(axes, reports, titles, strict=True):
        each.set_title(title)
        _windows(each, report["n50_d30"])
    axes[0].set_ylabel("|N50 − D30| / standard error")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _windows(axes: Axes, disagreement: dict[str, dict[str, float | None]]) -> None:
    """|N50 - D30| in standard errors, before and after, of what is compared both times."""
    names = [n for n in _NAMES if n in disagreement and None not in disagreement[n].values()]
    for offset, key, label in ((-0.2, "before_sigma", "declared model"), (0.2, "after_sigma", "after the diagnosis")):
        places = [k + offset for k in range(len(names))]
        axes.bar(places, [disagreement[n][key] or 0.0 for n in names], 0.38, label=label)
    axes.axhline(_SIGNIFICANT, color="black", linestyle="--", linewidth=1.0)
    axes.set_yscale("log")
    axes.set_xticks(range(len(names)), [_NAMES[n] for n in names])


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
