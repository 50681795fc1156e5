"""The documents as their readers see them: blocks to type in, files to write, links, paths in backticks.

A block may carry marks, comments in the lines right above it, that readers of the page do not see:

    <!-- walked with: s/--shots 20/--shots 3/ -->      a shorter version for the tests, by sed, of this block only
    <!-- not walked: needs a second computer -->       it cannot run here; why
    <!-- file: my_lna/backend.py -->                   it is the content of this file
    <!-- ends with: 22 -->                             exit code of the block, if not 0
    <!-- says: dusty@1 -->                             what it prints holds this; may be repeated

A block of the language `text` is what the `sh` block before it prints, with other numbers (see `shows`):

    <!-- digits: the same -->                          with the same numbers"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
KEYS = ("walked with", "not walked", "file", "ends with", "says", "digits")
_FENCE = re.compile(r"^( *)```(\w*|\{[\w-]+\})\s*$")  # {name}: a directive of the site's generator
_MARK = re.compile(r"^ *<!-- (.*?): (.*) -->\s*$")
_LINK = re.compile(r"(?<!`)\[[^\]]*\]\(([^)\s]+)\)")
_NUMBER = re.compile(r"(?:(?<!\w)[-−+])?\d[\d.]*(?:\(\d+\))?(?:[eE][-+]?\d+)?(?:-\d+)*")


@dataclass(frozen=True)
class Block:
    """A fenced block; `line` is that of its fence, from 1. `marks` are pairs of key and text."""

    page: str
    line: int
    language: str
    text: str
    marks: tuple[tuple[str, str], ...]

    @property
    def place(self) -> str:
        """Page and line."""
        return f"{self.page}:{self.line}"

    def mark(self, key: str) -> str | None:
        """The text of a mark; None: there is none."""
        return next((text for name, text in self.marks if name == key), None)

    def says(self) -> list[str]:
        """What its output must hold."""
        return [text for name, text in self.marks if name == "says"]


def pages() -> list[str]:
    """All documents, from the root."""
    found = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "tests").rglob("*.md"))]
    return [str(path.relative_to(ROOT)) for path in found if path.is_file()]


def blocks(page: str) -> Iterator[Block]:
    """The blocks of a page in order. Raises ValueError for a mark that nobody knows, or that stands above no block."""
    lines = (ROOT / page).read_text().splitlines()
    marks: list[tuple[str, str]] = []
    number = 0
    while number < len(lines):
        line = lines[number]
        number += 1
        if mark := _MARK.match(line):
            if mark[1] not in KEYS:
                raise ValueError(f"{page}:{number}: no mark is called {mark[1]!r}; known: {', '.join(KEYS)}")
            marks.append((mark[1], mark[2].strip()))
            continue
        fence = _FENCE.match(line)
        if fence is None and marks:
            raise ValueError(f"{page}:{number}: a mark stands right above its block")
        if fence is None:
            continue
        end = next(at for at in range(number, len(lines)) if lines[at].strip() == "```")
        text = "".join(one.removeprefix(fence[1]) + "\n" for one in lines[number:end])
        yield Block(page, number, fence[2], text, tuple(marks))
        marks, number = [], end + 1


def prose(page: str) -> str:
    """A page without its blocks and marks."""
    text = re.sub(r"^( *)```.*?^ *```\s*$", "", (ROOT / page).read_text(), flags=re.DOTALL | re.MULTILINE)
    return re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)


def links(page: str) -> list[str]:
    """The targets of its links and pictures."""
    return _LINK.findall(prose(page))


def headings(page: str) -> set[str]:
    """Anchors of its headings, as code hosts make them."""
    titles = re.findall(r"^#+ +(.+)$", prose(page), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in titles}


def ticks(page: str) -> list[str]:
    """What stands in backticks in its text."""
    return re.findall(r"`([^`\n]+)`", prose(page))


def shows(printed: str, output: str, *, digits: bool = False) -> str | None:
    """The first line of a `text` block that the output does not hold; None: it holds them all, in this order.

    Numbers are equal if both are numbers, or, with `digits`, if they are written alike; spaces and rulers are as long
    as they like; `...` stands for any text.
    """
    have = [_plain(line, digits=digits) for line in output.splitlines()]
    at = 0
    for line in printed.splitlines():
        if not (wanted := _plain(line, digits=digits)) or wanted == "...":
            continue
        pattern = re.compile(re.escape(wanted).replace(re.escape("..."), ".*"))
        found = next((place for place in range(at, len(have)) if pattern.fullmatch(have[place])), None)
        if found is None:
            return line
        at = found + 1
    return None


def _plain(line: str, *, digits: bool) -> str:
    line = re.sub(r"[─━═┄-]{3,}", "─", line)
    return " ".join((line if digits else _NUMBER.sub("0", line)).split())
