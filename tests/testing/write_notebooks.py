"""Run the notebooks of the examples, and write them with their outputs into docs/notebooks.

python -m tests.testing.write_notebooks --only own-term.ipynb
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

import nbformat

from tests.kit.notebooks import SHOWN, executed, names


def main() -> int:
    """By hand."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", help="name of a file in examples/notebooks; may be repeated")
    chosen = parser.parse_args().only or names()
    SHOWN.mkdir(exist_ok=True)
    for name in chosen:
        with tempfile.TemporaryDirectory() as folder:
            nbformat.write(executed(name, Path(folder)), SHOWN / name)
        print(f"{name}: {(SHOWN / name).stat().st_size / 1e3:.0f} kB", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
