"""Draws the rooms and who imports whom, from the imports themselves: python -m tests.system.rooms_picture [PNG].

Each room of the daemon and each of the other packages is a box, on the layer that import-linter holds it to; an arrow
goes from each importer down to what it imports, the thicker the more modules do so.
"""

from __future__ import annotations

import argparse
import tomllib
from collections import Counter
from pathlib import Path

import grimp
import matplotlib
from matplotlib.axes import Axes

matplotlib.use("Agg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).parents[2]
PACKAGES = ("platform_daemon", "drivers", "sequences", "sim_backend")
OUTSIDE = ("sim_backend", "sequences", "drivers")
TARGET = ROOT / "docs" / "pictures" / "rooms.png"


def layers() -> list[list[str]]:
    """The rooms of the daemon, top layer first, as pyproject.toml holds them."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    rooms = next(c["layers"] for c in contracts if c["name"].startswith("the daemon: "))
    return [[each.strip().removeprefix("platform_daemon.") for each in row.split("|")] for row in rooms[1:]]


def arrows() -> Counter[tuple[str, str]]:
    """(importer, imported) -> how many modules of the one import the other."""
    graph = grimp.build_graph(*PACKAGES)
    found: Counter[tuple[str, str]] = Counter()
    for module in graph.modules:
        for other in {room_of(m) for m in graph.find_modules_directly_imported_by(module)}:
            if other != room_of(module):
                found[room_of(module), other] += 1
    return found


def room_of(module: str) -> str:
    """`platform_daemon.core.hardware.shot` belongs to core.hardware, `drivers.errors` to drivers."""
    parts = module.split(".")
    if parts[0] != "platform_daemon" or len(parts) == 1:
        return parts[0]
    return ".".join(parts[1:3]) if parts[1] == "core" else parts[1]


def places() -> dict[str, tuple[float, float]]:
    """Where each box stands: the daemon's layers downwards in zigzag, the other packages beside and below them."""
    rows = [row for row in layers() if row]
    found = {}
    for y, row in enumerate(rows):
        for x, room in enumerate(row):
            found[room] = (3.0 * (x - 0.5 * (len(row) - 1)) + (0.5 if y % 2 else -0.5), -float(y))
    lowest = 1.0 - len(rows)
    return found | {"sequences": (3.2, lowest), "drivers": (1.2, lowest - 1.0), "sim_backend": (3.2, lowest - 2.0)}


def draw(target: Path) -> None:
    """The picture as PNG."""
    figure, axes = plt.subplots(figsize=(9, 12), layout="tight")
    where = places()
    for (above, below), count in sorted(arrows().items()):
        if above in where and below in where:
            _arrow(axes, where[above], where[below], count)
    for room, (x, y) in where.items():
        colour = "#dbe7f3" if room not in OUTSIDE else "#f3ead6"
        box = {"boxstyle": "round,pad=0.5", "facecolor": colour, "edgecolor": "#34495e"}
        axes.text(x, y, room, ha="center", va="center", fontsize=11, bbox=box, zorder=3)
    axes.set_xlim(min(x for x, _ in where.values()) - 0.8, max(x for x, _ in where.values()) + 0.8)
    axes.set_ylim(min(y for _, y in where.values()) - 0.5, 0.5)
    axes.set_axis_off()
    figure.savefig(target, dpi=110)
    plt.close(figure)


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], count: int) -> None:
    bend = 0.12 if abs(start[1] - end[1]) > 1.5 else 0.0
    style = {
        "arrowstyle": "-|>",
        "color": "#7f8c8d",
        "connectionstyle": f"arc3,rad={bend}",
        "shrinkA": 14,
        "shrinkB": 14,
    }
    axes.annotate("", end, start, arrowprops={**style, "linewidth": 0.4 + 0.12 * min(count, 25)}, zorder=1)


def main() -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("png", type=Path, nargs="?", default=TARGET, help="file to write")
    parser.add_argument("--list", action="store_true", help="print the arrows with their counts, draw nothing")
    asked = parser.parse_args()
    if asked.list:
        for (above, below), count in sorted(arrows().items()):
            print(f"{above:16} -> {below:16} {count}")
    else:
        draw(asked.png)
        print(asked.png)


if __name__ == "__main__":
    main()
