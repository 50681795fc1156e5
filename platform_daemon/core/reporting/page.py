"""Self-contained HTML pages from a template: words, tables and pictures; nothing is loaded from anywhere."""

from __future__ import annotations

import base64
import platform
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from matplotlib.figure import Figure

from platform_daemon import __version__

from .figures import png_of

_DPI = 100


def page(template: str, filters: Mapping[str, Callable[..., Any]], **values: Any) -> bytes:
    """The page in UTF-8; every template knows `software` and `made`, and the filters `png` and `file_name`."""
    made = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {"file_name": lambda path: path.rpartition("/")[2], "png": _base64_png, **filters}
    libraries = f"Python {platform.python_version()}, numpy {np.__version__}, scipy {scipy.__version__}"
    known = {"software": f"{__version__}, {libraries}", "made": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")}
    return made.get_template(template).render(**known, **values).lstrip().encode(errors="backslashreplace")


def _base64_png(figure: Figure) -> str:
    """As data, so that the page needs no other file."""
    return base64.b64encode(png_of(figure, _DPI)).decode()
