"""The notebooks of the examples with their outputs, as the site shows them."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbformat import NotebookNode
from PIL import Image

from tests.kit.data import ROOT

EXAMPLES = ROOT / "examples/notebooks"
SHOWN = ROOT / "docs/notebooks"
_COLOURS = 48
_LONGEST_S = 900  # of one cell, on a computer that is busy


def names() -> list[str]:
    """The names of all notebooks."""
    return sorted(path.name for path in EXAMPLES.glob("*.ipynb"))


def executed(name: str, folder: Path) -> NotebookNode:
    """That notebook, run in an empty folder.  Raises CellExecutionError."""
    notebook = nbformat.read(EXAMPLES / name, as_version=4)
    NotebookClient(notebook, timeout=_LONGEST_S, resources={"metadata": {"path": str(folder)}}).execute()
    return _tidied(notebook)


def _tidied(notebook: NotebookNode) -> NotebookNode:
    """Without the times of cells and the versions of this machine; of a cell that is replaced, its last state."""
    notebook.metadata.pop("widgets", None)
    notebook.metadata.language_info = {"name": "python"}
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
        for output in cell.get("outputs", []):
            output.get("metadata", {}).pop("execution", None)
            output.pop("transient", None)
            data = output.get("data", {})
            if "image/png" in data:
                data["image/png"] = _in_few_colours(data["image/png"])
    return notebook


def _in_few_colours(png: str) -> str:
    """A PNG in base64 as a smaller one: pictures of lines have few colours."""
    smaller = io.BytesIO()
    picture = Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB")
    picture.quantize(_COLOURS).save(smaller, "PNG", optimize=True)
    return base64.b64encode(smaller.getvalue()).decode()
