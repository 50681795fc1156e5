"""What a binary answer or file is made of, without its numbers."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import h5py
import numpy as np


def structure_text(source: Path | io.BytesIO) -> str:
    """Every group and dataset of an HDF5 file with shape, type and attributes, one per line."""
    lines = []
    with h5py.File(source, "r") as file:
        lines.append(f"/{_attributes(file)}")
        file.visititems(lambda name, item: lines.append(f"/{name}{_shape(item)}{_attributes(item)}"))
    return "\n".join(lines) + "\n"


def _shape(item: Any) -> str:
    return f" {item.shape} {item.dtype}" if isinstance(item, h5py.Dataset) else ""


def _attributes(item: Any) -> str:
    return "".join(f" {name}={np.asarray(value).tolist()!r}" for name, value in sorted(item.attrs.items()))


def body_structure(content: bytes, media_type: str) -> str:
    """One or more lines on a binary body: what it is and how large its arrays are; never its numbers."""
    if content.startswith(b"\x93NUMPY"):
        array = np.load(io.BytesIO(content))
        return f"npy {array.shape} {array.dtype}\n"
    if content.startswith(b"\x89HDF"):
        return structure_text(io.BytesIO(content))
    if media_type.startswith("text/html"):
        return f"html: {content.lstrip()[:15].decode(errors='replace').lower()}\n"
    return f"{len(content)} bytes\n" if len(content) < 100 else "many bytes\n"
