"""A package of somebody else that publishes entry points: a folder for the Python path, without an installation."""

from __future__ import annotations

from pathlib import Path


def entry_point_package(folder: Path, module: str, text: str, group: str, **entries: str) -> Path:
    """Write a module and its metadata into a folder; entries: name of an entry point -> what it names."""
    folder.mkdir(exist_ok=True)
    (folder / f"{module}.py").write_text(text)
    info = folder / f"{module}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    lines = "\n".join(f"{name} = {value}" for name, value in entries.items())
    (info / "entry_points.txt").write_text(f"[{group}]\n{lines}\n")
    return folder
