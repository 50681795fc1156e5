"""The map of the room names every module that stands in it."""

import re
from pathlib import Path

from platform_daemon import estimation


def test_the_map_names_every_module():
    room = Path(estimation.__file__).parent
    modules = {p.stem for p in room.glob("*.py")} - {"__init__"} | {p.parent.name for p in room.glob("*/__init__.py")}
    words = set(re.findall(r"[a-z_]+\*?", estimation.__doc__))
    families = {word[:-1] for word in words if word.endswith("*")}
    missing = {m for m in modules - words if not any(m.startswith(f) for f in families)}
    assert not missing
