"""A characterisation in words and as a page: the same tables, whole, also where nothing could be fitted."""

import pytest

from platform_daemon.features.characterise.page import characterisation_html
from platform_daemon.features.characterise.report import characterisation_tables, characterisation_text
from platform_daemon.features.characterise.tables import characterisation_task, characterise, shown_shot
from platform_daemon.features.fit.batch.executors import in_this_process
from platform_daemon.features.fit.fit_request import FitSettings
from tests.kit.html_pages import (
    assert_nothing_is_loaded,
    assert_pictures_speak_and_tables_are_whole,
    elements,
    pictures,
)
from tests.kit.ring_down_series import jewels, write_ring_downs


def made(path):
    """(report, page)"""
    task = characterisation_task(path, FitSettings(), None, 0.001)
    with in_this_process() as workers:
        report = characterise(task, workers, lambda what, share: None)
    return report, characterisation_html(report, shown_shot(task, report)).decode()


@pytest.fixture(scope="module")
def some(tmp_path_factory):
    return made(write_ring_downs(tmp_path_factory.mktemp("page") / "some.h5", [*jewels(3), None]))


@pytest.fixture(scope="module")
def none(tmp_path_factory):
    return made(write_ring_downs(tmp_path_factory.mktemp("page") / "none.h5", [None, None]))


@pytest.mark.long
def test_the_page_is_whole_and_loads_nothing(some):
    assert_nothing_is_loaded(some[1])
    assert_pictures_speak_and_tables_are_whole(some[1])
    assert pictures(some[1]) == 3  # a shot with its fit, envelopes, every shot


def test_page_and_terminal_tell_the_same_tables(some):
    report, page = some
    cells = {"".join(e.itertext()) for e in elements(page) if e.tag in ("td", "th")}
    printed = characterisation_text(report)
    for table in characterisation_tables(report):
        assert table.title in page
        assert table.title in printed
        for row in table.rows():
            assert set(row) <= cells


def test_the_numbers_are_those_of_the_report(some):
    report, _ = some
    _, quality, parameters, compared, uncertain, means, factors = characterisation_tables(report)
    f_nat = report.d30.parameters["f_nat_hz"]
    assert dict(parameters.columns)["f_nat / Hz"][1] == f"{f_nat.mean:.3f} ± {f_nat.std:.3f}"
    assert dict(quality.columns)["good shots"] == ["3 of 4", "3 of 4"]
    assert dict(compared.columns)["shots"][0] == "3"
    assert dict(uncertain.columns)["uncertainty"][0] == f"{report.uncertainties[0].uncertainty:.2g}"
    assert dict(means.columns)["U"][0] == f"{report.mean_budgets[0].U:.2g}"
    assert dict(factors.columns)["median"][0] == f"{report.quality_factors.n50.median:.0f}"
    assert dict(parameters.columns)["λ / s⁻¹"][0].endswith("held")


def test_where_nothing_was_fitted_the_page_says_so(none):
    report, page = none
    assert_pictures_speak_and_tables_are_whole(page)
    assert pictures(page) == 0
    assert "No shot has a good D30 fit." in page
    assert all(note.replace("&", "&amp;") in page for note in report.notes)
    assert "nan" not in characterisation_text(report).lower()
