"""The index of what has been measured names pages, code and commits that exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.evidence import pages as evidence


@pytest.mark.long
def test_the_index_is_what_its_data_say() -> None:
    assert evidence.is_current(), "run `make evidence`"


def test_every_page_of_evidence_is_in_the_index_and_every_entry_has_its_page() -> None:
    written = {path.stem for path in evidence.FOLDER.glob("*.md")} - {"index"}
    assert {page.name for page in evidence.read_pages()} == written


def test_the_code_that_a_page_is_about_exists() -> None:
    missing = {
        page.name: [path for path in page.proves if not (evidence.ROOT / path).exists()]
        for page in evidence.read_pages()
    }
    assert {name: paths for name, paths in missing.items() if paths} == {}


def test_every_figure_that_names_a_page_names_one_that_exists() -> None:
    names = {page.name for page in evidence.read_pages()}
    assert {figure.page for figure in evidence.read_figures()} - {None} <= names


def test_commands_that_repeat_a_measurement_are_targets_of_the_makefile_or_programs() -> None:
    targets = set(re.findall(r"^([\w-]+):", (evidence.ROOT / "Makefile").read_text(), re.MULTILINE))
    commands = [page.command for page in evidence.read_pages() if page.command]
    commands += [figure.command for figure in evidence.read_figures()]
    made = [command.split()[1] for command in commands if command.startswith("make ")]
    assert made
    assert [target for target in made if target not in targets] == []
    programs = [command.split()[2] for command in commands if command.startswith("python -m ")]
    assert [name for name in programs if not _is_program(name)] == []


def _is_program(module: str) -> bool:
    path = evidence.ROOT / module.replace(".", "/")
    return path.with_suffix(".py").is_file() or (path / "__main__.py").is_file()


def test_without_the_history_of_the_repository_the_age_is_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    page = evidence.Page(name="soak", title="", measured_on="0000000", proves=("drivers",))
    monkeypatch.setattr(evidence, "read_pages", lambda: [page])
    with pytest.raises(evidence.UnknownHistoryError):
        evidence.change_since(page)
    assert "age unknown" in evidence.check()[0]
    assert "The age is unknown" in evidence.index()


def test_a_file_that_was_only_moved_has_not_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evidence, "ROOT", tmp_path)
    monkeypatch.setenv("GIT_CONFIG_GLOBAL", "/dev/null")
    for name in ("GIT_AUTHOR", "GIT_COMMITTER"):
        monkeypatch.setenv(f"{name}_NAME", "reader")
        monkeypatch.setenv(f"{name}_EMAIL", "reader@example.org")

    def commit() -> str:
        evidence.git("add", "--all")
        evidence.git("commit", "--quiet", "--message", "step")
        return evidence.git("rev-parse", "HEAD").strip()

    evidence.git("init", "--quiet")
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "a.py").write_text("".join(f"line {number}\n" for number in range(50)))
    measured = commit()
    (tmp_path / "old").rename(tmp_path / "new")
    moved = commit()
    (tmp_path / "new" / "a.py").write_text((tmp_path / "new" / "a.py").read_text() + "one more\n")
    commit()

    def change(since: str, until: str) -> evidence.Change:
        evidence.changed_lines.cache_clear()
        evidence.git("checkout", "--quiet", until)
        page = evidence.Page(name="x", title="", measured_on=since, proves=("new",))
        return evidence.change_since(page)

    last = evidence.git("rev-parse", "HEAD").strip()
    assert change(measured, moved) == evidence.Change(lines=0, files=0)
    assert change(measured, last) == evidence.Change(lines=1, files=1)
    evidence.changed_lines.cache_clear()


def test_a_page_that_was_measured_again_notes_the_commit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    copy = tmp_path / "pages.toml"
    copy.write_text(evidence.DATA.read_text())
    monkeypatch.setattr(evidence, "DATA", copy)
    monkeypatch.setattr(evidence, "git", lambda *words: "abcdef12\n")
    before = {page.name: page for page in evidence.read_pages()}
    evidence.note_measured("soak")
    after = {page.name: page for page in evidence.read_pages()}
    assert after["soak"].measured_on == "abcdef12"
    assert {name: page for name, page in after.items() if name != "soak"} == {
        name: page for name, page in before.items() if name != "soak"
    }
    with pytest.raises(SystemExit, match="no page 'soap'"):
        evidence.note_measured("soap")
