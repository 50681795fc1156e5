"""What the documents say can be done, is there, and is called so."""

from __future__ import annotations

import importlib
import re
import shlex
import tomllib
from functools import cache
from pathlib import Path

import pytest
import typer.testing

from platform_daemon.cli.main import app
from platform_daemon.estimation.physics.torques.own_terms import GROUP
from tests.kit.pages import ROOT, blocks, headings, links, pages, prose, shows, ticks
from tests.system.walk import PAGES, StumbleError, walk

ROOMS = [path.name for path in (ROOT / "platform_daemon").iterdir() if path.is_dir()]
TOP = ["config", "demo", "docs", "drivers", "platform_daemon", "sequences", "sim_backend", "tests", *ROOMS]
FILE = re.compile(rf"(?:(?:{'|'.join(TOP)})/[\w.*{{}},/-]*|[\w/]+\.(?:py|pyi|md))")
MODULE = re.compile(r"(?:platform_daemon|drivers|sequences|sim_backend|tests)(?:\.\w+)+(?:\(\))?")
LONGEST_LINE = 110  # characters of prose; tables, pictures and headings cannot be wrapped
READING = [
    page for page in pages() if page.startswith(("README.md", "docs/tutorial/", "docs/howto/", "docs/reference/"))
]
READING += [page for page in pages() if page.startswith("docs/explanation/") and "architecture" not in page]
MADE_BY_COMMANDS = ("demo/",)  # what does not exist before
BRIEF = "docs/reference/configuration.md"  # four short commands; README.md takes a minute of a processor


@pytest.mark.parametrize("page", pages())
def test_every_link_leads_somewhere(page: str) -> None:
    broken = [target for target in links(page) if not _leads_somewhere(page, target)]
    assert broken == []


def _leads_somewhere(page: str, target: str) -> bool:
    if target.startswith(("http://", "https://")):
        return True
    name, _, anchor = target.partition("#")
    where = (ROOT / page).parent / name if name else ROOT / page
    if not where.resolve().exists():
        return False
    return not anchor or anchor in headings(str(where.resolve().relative_to(ROOT)))


@pytest.mark.parametrize("page", pages())
def test_every_file_that_a_page_names_is_there(page: str) -> None:
    assert [name for name in ticks(page) if FILE.fullmatch(name) and not _is_there(page, name)] == []


def _is_there(page: str, name: str) -> bool:
    """A path from the root, a file that the page has one make, or, without a folder, a file of that name anywhere."""
    if name.startswith(MADE_BY_COMMANDS) or name in {block.mark("file") for block in blocks(page)}:
        return True
    if "/" not in name:
        return any(ROOT.glob(name)) or any(any((ROOT / top).rglob(name)) for top in TOP[:8])
    return any(any(top.glob(name.rstrip("/"))) for top in (ROOT, ROOT / "platform_daemon"))


@pytest.mark.parametrize("page", pages())
def test_every_module_that_a_page_names_can_be_imported(page: str) -> None:
    groups = {*tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"], GROUP}
    for name in ticks(page):
        if MODULE.fullmatch(name) and name not in groups:
            _import(name.removesuffix("()"))


def _import(name: str) -> None:
    """A module, or what stands in one.  Raises ImportError, AttributeError."""
    module, _, last = name.rpartition(".")
    try:
        importlib.import_module(name)
    except ModuleNotFoundError:
        getattr(importlib.import_module(module), last)


def _commands(page: str) -> list[list[str]]:
    """All commands `platform-daemon ...` in its blocks and its text, without what a shell does with their output."""
    printed = [block.text.replace("\\\n", " ") for block in blocks(page) if block.language == "sh"]
    written = ["".join(f"{one}\n" for one in ticks(page))]
    found = re.findall(r"(?<!-e )platform-daemon ((?:'[^'\n]*'|[^`|>&\n])+)", "".join(printed + written))
    return [shlex.split(one, comments=True) for one in found]


@pytest.mark.parametrize("page", pages())
def test_every_command_and_option_that_a_page_prints_exists(page: str) -> None:
    for words in _commands(page):
        names = tuple(word for word in words[:2] if re.fullmatch(r"[a-z-]+", word) and not word.startswith("-"))
        options = {word.partition("=")[0] for word in words if word.startswith("--")}
        missing = options - _options(names, "--live" in options)
        assert not missing, f"platform-daemon {' '.join(words)}: {missing}"


@cache
def _options(names: tuple[str, ...], live: bool) -> set[str]:
    """The options that the help of a command lists; the second of two names may be an argument."""
    words = [*names, *(["--live"] if live else []), "--help"]
    answer = typer.testing.CliRunner().invoke(app, words, env={"COLUMNS": "200", "TERM": "dumb"})
    assert answer.exit_code == 0, f"platform-daemon {' '.join(names)}: {answer.output}"
    return {"--live", *re.findall(r"--[a-z][a-z-]*", answer.output)}


@pytest.mark.parametrize("page", READING)
def test_prose_is_wrapped_so_that_a_changed_sentence_is_a_small_difference(page: str) -> None:
    lines = prose(page).splitlines()
    assert [line for line in lines if len(line) > LONGEST_LINE and not line.startswith(("|", "![", "#"))] == []


@pytest.mark.parametrize("page", PAGES)
def test_what_is_marked_as_a_file_is_named_to_the_reader(page: str) -> None:
    text = prose(page)
    assert [name for block in blocks(page) if (name := block.mark("file")) and f"`{name}`" not in text] == []


def test_commands_are_called_in_one_way() -> None:
    assert [
        page for page in pages() if ".venv/bin/" in (ROOT / page).read_text().replace(". .venv/bin/activate", "")
    ] == []


def test_printed_output_is_compared_but_for_its_numbers() -> None:
    assert shows("a = 1.5(2) of 3 ...", "x\na  =  -2e5 of 17 and more\n") is None
    assert shows("a = 1.5\nb", "b\na = 1\n") == "b"
    assert shows("a is 1", "a was 1") == "a is 1"
    assert shows("a = 1.5(2)", "a  =  1.5(2)", digits=True) is None
    assert shows("a = 1.5(2)", "a = 1.5(3)", digits=True) == "a = 1.5(2)"


def _page(name: str, text: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    monkeypatch.setattr("tests.kit.pages.ROOT", tmp_path)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("```sh\ntrue\nfalse\necho no\n```\n", "page.md:1: failed: false"),
        ("```sh\nfalse | cat\n```\n", "page.md:1: failed: cat"),
        ("<!-- says: four -->\n```sh\necho three\n```\n", "'four' was not printed"),
        ("```sh\necho three\n```\n```text\nfour\n```\n", "nothing like 'four' was printed"),
        ("```sh\nsleep 77 &\n```\n", "left running at the end: sleep 77"),
        ("<!-- ends with: 3 -->\n```sh\ntrue\n```\n", "ended with 0, not 3"),
        ("```toml\na = \n```\n", "page.md:1: no TOML"),
        ("<!-- walked with: s/a/b/ -->\n```sh\ntrue\n```\n", "changes nothing"),
    ],
)
def test_the_walk_stumbles_over_what_is_wrong(
    text: str, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _page("page.md", text, monkeypatch, tmp_path)
    monkeypatch.setattr("tests.system.walk.GOODBYE_S", 0.5)
    with pytest.raises(StumbleError, match=re.escape(why)):
        walk(["page.md"], tmp_path, warm=False)


def test_a_mark_that_nobody_knows_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _page("page.md", "<!-- walkt with: x -->\n```sh\ntrue\n```\n", monkeypatch, tmp_path)
    with pytest.raises(ValueError, match=r"page.md:1: no mark is called 'walkt with'"):
        list(blocks("page.md"))


@pytest.mark.long
def test_a_page_can_be_walked_through(tmp_path: Path) -> None:
    walk([BRIEF], tmp_path, warm=False)


@pytest.mark.long
def test_the_first_page_can_be_walked_through(tmp_path: Path) -> None:
    walk(["README.md"], tmp_path)


@pytest.mark.campaign
def test_all_pages_can_be_walked_through_in_one_shell(tmp_path: Path) -> None:
    walk(PAGES, tmp_path)
