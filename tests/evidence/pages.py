"""Pages of docs/evidence, the commits they were measured on, and what has changed since."""

from __future__ import annotations

import re
import subprocess
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "evidence"
DATA = FOLDER / "pages.toml"
INDEX = FOLDER / "index.md"
AGE_HEADING = "## Older than their code"
"""Where the part of the index begins that depends on the commit it is written on."""

_HEAD = """\
# What has been measured

`make evidence` writes this page from `docs/evidence/pages.toml`; change that file instead. The measurements are
repeated by the commands in the tables, in the folder of the checkout. Each page says on which data and on which
computer it was measured.

"""


class UnknownHistoryError(Exception):
    """Git cannot compare a commit with the files here; the text says why."""


@dataclass(frozen=True, kw_only=True)
class Page:
    """A page of docs/evidence: `measured_on` is a commit, `proves` are paths of code from the root."""

    name: str
    title: str
    measured_on: str
    proves: tuple[str, ...]
    command: str | None = None


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A row of the table of figures; `page` is the name of the page that has all figures of its kind."""

    what: str
    data: str
    value: str
    command: str
    page: str | None = None


@dataclass(frozen=True, kw_only=True)
class Change:
    """Lines added and removed since a commit, in a number of files."""

    lines: int
    files: int


def read_pages() -> list[Page]:
    """The pages, in the order of pages.toml."""
    found = tomllib.loads(DATA.read_text())["pages"]
    return [Page(name=name, **{**entry, "proves": tuple(entry["proves"])}) for name, entry in found.items()]


def read_figures() -> list[Figure]:
    """The rows of the table of figures, in the order of pages.toml."""
    return [Figure(**entry) for entry in tomllib.loads(DATA.read_text())["figures"]]


def change_since(page: Page) -> Change:
    """What has changed in the code of a page.  Raises UnknownHistoryError."""
    changed = [
        count
        for path, count in changed_lines(page.measured_on).items()
        if count and any(path == proved or path.startswith(f"{proved}/") for proved in page.proves)
    ]
    return Change(lines=sum(changed), files=len(changed))


@cache
def changed_lines(commit: str) -> Mapping[str, int]:
    """Lines added and removed since a commit by the path of today; binary files count as one line."""
    try:
        fields = git("diff", "--numstat", "-z", "--find-renames", commit, "HEAD").split("\0")
    except (OSError, subprocess.CalledProcessError) as error:
        said = getattr(error, "stderr", None) or str(error)
        raise UnknownHistoryError(said.strip().splitlines()[0]) from None
    changed: dict[str, int] = {}
    rest = iter(fields)
    for entry in rest:
        if not entry:
            continue
        added, removed, path = entry.split("\t")
        if not path:  # a rename: the old and the new path are fields of their own
            next(rest)
            path = next(rest)
        changed[path] = 1 if added == "-" else int(added) + int(removed)
    return changed


def git(*words: str) -> str:
    """What a git command prints.  Raises OSError, CalledProcessError."""
    return subprocess.run(["git", *words], cwd=ROOT, check=True, capture_output=True, text=True).stdout


def index() -> str:
    """The text of index.md."""
    pages = read_pages()
    figures = [
        "## Figures\n",
        "| what | data | value | repeated by | page |",
        "|---|---|---|---|---|",
        *(_figure_row(figure) for figure in read_figures()),
    ]
    campaigns = [
        "\n## Pages\n",
        "| page | measured on commit | repeated by | code that it is about |",
        "|---|---|---|---|",
        *(_page_row(page) for page in pages),
    ]
    return _HEAD + "\n".join([*figures, *campaigns, f"\n{AGE_HEADING}\n", *_ages(pages)]) + "\n"


def _figure_row(figure: Figure) -> str:
    link = f"[{figure.page}]({figure.page}.md)" if figure.page else ""
    return f"| {figure.what} | {figure.data} | {figure.value} | `{figure.command}` | {link} |"


def _page_row(page: Page) -> str:
    command = f"`{page.command}`" if page.command else "by hand; the page says how"
    proves = ", ".join(f"`{path}`" for path in page.proves)
    return f"| [{page.title}]({page.name}.md) | `{page.measured_on}` | {command} | {proves} |"


def _ages(pages: list[Page]) -> list[str]:
    try:
        head = git("rev-parse", "--short", "HEAD").strip()
        rows = [_age_row(page) for page in pages]
    except (OSError, subprocess.CalledProcessError, UnknownHistoryError):
        return ["The age is unknown: this page was written without the history of the repository."]
    return [
        f"Changes between the commit of a page and `{head}`, on which this table was written. `make check` prints the",
        "pages that are older than their code now.\n",
        "| page | changed since |",
        "|---|---|",
        *rows,
    ]


def _age_row(page: Page) -> str:
    change = change_since(page)
    said = f"{change.lines} lines in {change.files} files" if change.lines else "nothing"
    return f"| [{page.name}]({page.name}.md) | {said} |"


def check() -> list[str]:
    """A line for every page that is older than its code, and one if the index is out of date."""
    said = []
    for page in read_pages():
        try:
            change = change_since(page)
        except UnknownHistoryError as error:
            said.append(f"{page.name}.md: age unknown, git says: {error}")
            continue
        if change.lines:
            repeat = f"; repeat it by: {page.command}" if page.command else ""
            measured = f"measured on {page.measured_on}, its code has changed since"
            said.append(f"{page.name}.md: {measured} by {change.lines} lines in {change.files} files{repeat}")
    if not is_current():
        said.append("docs/evidence/index.md is not what pages.toml says: run `make evidence`")
    return said


def is_current() -> bool:
    """Whether index.md is what would be written now, apart from the ages, which change with each commit."""
    if not INDEX.exists():
        return False
    return INDEX.read_text().partition(AGE_HEADING)[0] == index().partition(AGE_HEADING)[0]


def note_measured(name: str) -> None:
    """Write the commit that is checked out into the entry of a page.  Raises SystemExit if there is no such page."""
    text = DATA.read_text()
    entry = re.compile(rf'(?<=^\[pages\.{re.escape(name)}\]\n)((?:(?!\[).*\n)*?measured_on = )"\w+"', re.MULTILINE)
    changed, found = entry.subn(rf'\1"{git("rev-parse", "--short=8", "HEAD").strip()}"', text)
    if not found:
        raise SystemExit(f"{DATA}: no page {name!r}; there are {', '.join(page.name for page in read_pages())}")
    DATA.write_text(changed)
