"""Where the example files and the shipped configuration are."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests" / "data"
CONFIG = ROOT / "config"
