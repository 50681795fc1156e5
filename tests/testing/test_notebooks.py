"""Every notebook runs from its first cell to its last, and stands in the site as it has run."""

import nbformat
import pytest

from tests.kit.notebooks import EXAMPLES, SHOWN, executed, names


def cells(folder, name):
    return nbformat.read(folder / name, as_version=4).cells


def code(found):
    return [cell for cell in found if cell.cell_type == "code"]


def kinds(found):
    """The kinds of output of each cell, as text and pictures."""
    return [
        {kind for output in cell.outputs for kind in output.get("data", {"text/plain": ""})} for cell in code(found)
    ]


def test_there_are_notebooks_and_their_outputs_are_not_kept_beside_their_source():
    assert len(names()) == 6
    for name in names():
        found = cells(EXAMPLES, name)
        assert found[0].cell_type == "markdown"
        assert all(not cell.get("outputs") for cell in found), name


@pytest.mark.parametrize("name", names())
def test_the_site_shows_a_notebook_as_it_is_with_the_outputs_of_a_run(name):
    """If not: `make notebooks`."""
    shown = cells(SHOWN, name)
    assert [cell.source for cell in shown] == [cell.source for cell in cells(EXAMPLES, name)]
    assert [cell.execution_count for cell in code(shown)] == list(range(1, len(code(shown)) + 1))
    assert not any(output.output_type == "error" for cell in code(shown) for output in cell.outputs)
    text = (SHOWN / name).read_text()
    assert [each for each in ("home", "root", "tmp", "Users") if f"/{each}/" in text] == []  # of whoever ran it
    assert len(text) < 400_000


@pytest.mark.long
@pytest.mark.parametrize("name", names())
def test_a_notebook_runs_to_its_end_with_the_outputs_that_are_shown(name, tmp_path):
    assert kinds(executed(name, tmp_path).cells) == kinds(cells(SHOWN, name))
