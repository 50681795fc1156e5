"""What every page that we make has to be: well-formed, self-contained, whole."""

from __future__ import annotations

import base64
import re
from xml.etree import ElementTree


def elements(page: str) -> list[ElementTree.Element]:
    """Every element of a page, which must be well-formed XML too."""
    doctype, _, rest = page.partition("\n")
    assert doctype == "<!doctype html>"
    return list(ElementTree.fromstring(rest).iter())


def assert_nothing_is_loaded(page: str) -> None:
    """Pictures are in it, and nothing is elsewhere."""
    seen = elements(page)
    keys = ("src", "href", "srcset", "data", "action")
    sources = [value for e in seen for key in keys if (value := e.get(key)) is not None]
    assert sources
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    assert not {"script", "link", "iframe", "object"} & {e.tag for e in seen}
    assert "@import" not in page
    assert not re.search(r"url\(", page)


def assert_pictures_speak_and_tables_are_whole(page: str) -> None:
    """Every picture has a text, every row of a table the same width."""
    seen = elements(page)
    assert all(e.get("alt") for e in seen if e.tag == "img")
    for table in (e for e in seen if e.tag == "table"):
        widths = {sum(int(cell.get("colspan", 1)) for cell in row) for row in table.iter("tr")}
        assert len(widths) == 1, ElementTree.tostring(table)


def pictures(page: str) -> int:
    """How many there are; all must be PNG."""
    found = re.findall(r"base64,([^\"]+)", page)
    assert all(base64.b64decode(p).startswith(b"\x89PNG") for p in found)
    return len(found)
