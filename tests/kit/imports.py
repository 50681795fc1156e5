"""What a fresh interpreter has loaded."""

from __future__ import annotations

import ast
import subprocess
import sys


def loaded(code: str, names: tuple[str, ...]) -> list[str]:
    """Which of these modules a fresh interpreter has loaded after this code."""
    found = f"import sys; {code}; print([name for name in {names!r} if name in sys.modules])"
    out = subprocess.run([sys.executable, "-c", found], capture_output=True, text=True, check=True, timeout=60)
    names_loaded: list[str] = ast.literal_eval(out.stdout.splitlines()[-1])
    return names_loaded
