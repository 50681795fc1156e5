"""Types of the examples."""

import subprocess
import sys

import pytest

from tests.kit.pages import ROOT


@pytest.mark.long
def test_mypy_is_content_with_every_example_in_its_strict_mode():
    """The package in turn is checked by `make check`."""
    files = sorted(str(path) for path in (ROOT / "examples").rglob("*.py"))
    words = [sys.executable, "-m", "mypy", "--strict", "--follow-imports", "silent", "--no-incremental", *files]
    out = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=540, check=False)
    assert out.returncode == 0, out.stdout
