"""The map of the room names every folder and module that stands in it."""

import re
from pathlib import Path

from platform_daemon import estimation

BESIDE = {"terms", "derived", "bench"}  # folders whose modules need no map


def test_the_map_names_every_module():
    room = Path(estimation.__file__).parent
    modules = {p.stem for p in room.rglob("*.py") if p.parent.name not in BESIDE} - {"__init__"}
    folders = {p.parent.name for p in room.glob("*/__init__.py")}
    assert not (modules | folders) - set(re.findall(r"[a-z_]+", estimation.__doc__))
