"""`python -m tests.system.golden make FOLDER | compare FOLDER [--exact]`."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from tests.system.golden.comparison import differences
from tests.system.golden.scenarios import SCENARIOS, make
from tests.system.golden.workplace import TREE


def main() -> int:
    """0: made, or nothing is different; 1: differences; 2: wrong arguments."""
    parser = argparse.ArgumentParser(prog="python -m tests.system.golden", description=__doc__)
    parser.add_argument("what", choices=("make", "compare"))
    parser.add_argument("folder", type=Path, help="golden files, a folder per scenario")
    parser.add_argument("--exact", action="store_true", help="byte for byte: for two trees on one computer")
    parser.add_argument("--only", action="append", choices=SCENARIOS, help="this scenario; may be repeated")
    parser.add_argument("--with", dest="made", type=Path, help="compare with this folder, made before")
    parser.add_argument("--tree", type=Path, default=TREE, help="source tree whose program is run")
    parser.add_argument("--at-once", type=int, default=1, help="so many scenarios at once")
    asked = parser.parse_args()
    names = asked.only or list(SCENARIOS)
    if asked.what == "make":
        taken = [n for n in names if (asked.folder / n).exists()]
        if taken:
            parser.error(f"{asked.folder / taken[0]} exists: remove it, or make another folder")
        make(asked.folder, names, asked.tree.absolute(), asked.at_once)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        made = asked.made or Path(folder)
        if asked.made is None:
            make(made, names, asked.tree.absolute(), asked.at_once)
        found = [f"{n}/{line}" for n in names for line in differences(asked.folder / n, made / n, exact=asked.exact)]
    print("\n".join(found) or "no difference")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
