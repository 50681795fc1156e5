"""Where compiled kernels are kept: next to their sources, else in the folder of the state, else nowhere; and where
matplotlib keeps its list of fonts.

numba reads the place from its environment variable when it is loaded, in this process and in those that it starts.
Without a place numba refuses to compile, and where an account has no home it makes a folder that is called `~`.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

import platform_daemon

from .state_home import state_home

FONTS = "MPLCONFIGDIR"
"""Variable that matplotlib reads."""
VARIABLE = "NUMBA_CACHE_DIR"
NOWHERE = os.devnull
"""Value of the variable by which kernels are compiled without a cache."""


def choose_kernel_cache() -> str | None:
    """Choose the place for this process and its children; what a person should know, None: nothing.

    To be called before numba is loaded.  The choice of a parent process is kept.
    """
    configured = os.environ.get(VARIABLE)
    if configured == NOWHERE or (configured and _takes_files(Path(configured))):
        return None
    if not configured and _takes_files(Path(platform_daemon.__file__).parent):
        return None
    try:
        place = state_home() / "platform-daemon" / "kernels"
    except RuntimeError:  # the account has no home
        place = None
    if place is not None and _takes_files(place):
        os.environ[VARIABLE] = str(place)
        return None
    os.environ[VARIABLE] = NOWHERE
    return (
        "compiled kernels cannot be kept, so that each program compiles them again: neither the installation nor the "
        "folder of the state can be written. Remedy: set XDG_STATE_HOME to a folder that this account may write"
    )


def choose_font_cache() -> None:
    """Let matplotlib keep its fonts in the folder of the state where the account has no home that it may write.

    To be called before matplotlib is loaded.  Where that folder cannot be written either, matplotlib says so itself.
    """
    if FONTS in os.environ:
        return
    with contextlib.suppress(RuntimeError):  # the account has no home
        if os.access(Path.home(), os.W_OK):
            return
    try:
        place = state_home() / "platform-daemon" / "matplotlib"
    except RuntimeError:  # nor a folder of the state
        return
    if _takes_files(place):
        os.environ[FONTS] = str(place)


def _takes_files(folder: Path) -> bool:
    """Whether a file can be made in the folder, which is made if missing."""
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
