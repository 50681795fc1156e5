"""How Sphinx makes the site of the pages in this folder and of the docstrings; `make site` runs it, offline."""

from __future__ import annotations

import re

project = "platform-daemon"
project_copyright = "the authors of platform-daemon"
extensions = ["myst_nb", "sphinx.ext.autodoc"]
exclude_patterns = ["Thumbs.db"]
html_theme = "furo"
html_title = project
html_copy_source = False
html_show_copyright = False
highlight_language = "text"

myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 4
nb_execution_mode = "off"  # the notebooks stand there with their outputs; `make notebooks` runs them

autodoc_default_options = {"members": True, "member-order": "bysource", "show-inheritance": True}
autodoc_typehints = "signature"
autodoc_preserve_defaults = False  # it cannot read the signatures that the client makes of the schemas
suppress_warnings = ["ref.python"]  # a builtin and a field of a schema with one name, as `type`


def setup(app) -> None:
    """Called by Sphinx at its start."""
    app.connect("autodoc-process-docstring", _to_restructured_text)
    app.connect("autodoc-skip-member", _skips)


def _skips(app, what, name: str, obj, skip: bool, options) -> bool | None:
    """Pydantic puts its settings into each model, and each variant of a generic model into the model's module."""
    return True if name == "model_config" or "[" in name else None


def _to_restructured_text(app, what, name, obj, options, lines: list[str]) -> None:
    """Docstrings here are plain text with `code` in backticks; Sphinx takes them for reStructuredText.

    A paragraph with columns or indented lines stays as it is typed, every other one is prose.
    """
    paragraphs = re.split(r"\n\s*\n", "\n".join(lines).strip("\n"))
    lines[:] = [line for paragraph in paragraphs for line in (*_paragraph(paragraph.splitlines()), "")]


def _paragraph(lines: list[str]) -> list[str]:
    is_list = lines[:1] != [] and lines[0].startswith("* ")
    is_typed = any(line.startswith(" ") or re.search(r"\S {2,}(?![A-Z])\S", line) for line in lines)
    if is_typed and not is_list:
        return ["::", "", *(f"    {line}" for line in lines)]
    return [_prose(line) for line in lines]


def _prose(line: str) -> str:
    bullet, text = ("* ", line[2:]) if line.startswith("* ") else ("", line)
    parts = re.split(r"(`[^`]+`)", text)
    return bullet + "".join(f"`{part}`" if part.startswith("`") else _escape(part) for part in parts)


def _escape(text: str) -> str:
    return re.sub(r"([\\*`|_])", r"\\\1", text)
