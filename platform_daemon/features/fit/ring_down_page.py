"""A frame with its fit as a self-contained HTML page in which one moves and zooms; nothing is loaded from anywhere."""

from __future__ import annotations

import base64
import os
import sys
import webbrowser
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from platform_daemon.core.reporting.figures import COLOURS
from platform_daemon.core.reporting.page import page

from .plot_data import RingDownPlotData
from .ring_down_figure import caption


def ring_down_html(picture: RingDownPlotData) -> bytes:
    """The page in UTF-8; it holds all samples, 4 bytes each for the signal and for the residual."""
    residual = None
    if picture.model is not None:
        residual = picture.measured[:, : picture.model.shape[1]] - picture.model[:, : picture.measured.shape[1]]
    return page(
        "ring_down_page.html",
        {},
        picture=picture,
        caption=caption(picture.fit),
        colours=COLOURS,
        rate_hz=picture.sampling_rate_hz,
        measured=_base64(picture.measured),
        residual=None if residual is None else _base64(residual),
    )


def _base64(samples: NDArray[np.float64]) -> str:
    """Channel after channel as little-endian float32."""
    return base64.b64encode(np.ascontiguousarray(samples, dtype="<f4").tobytes()).decode()


def open_in_browser(path: Path) -> None:
    """Show a page in the user's browser where there is a screen; elsewhere nothing happens."""
    # Without a screen, webbrowser would start a browser for text in this terminal.
    if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return
    webbrowser.open(path.absolute().as_uri())
