"""The page: self-contained, whole, and true to the JSON."""

import pytest

from platform_daemon.diagnosis.report import diagnosis_report
from platform_daemon.diagnosis.residual_comparison import compare_residuals
from platform_daemon.features.diagnose.load_shots import diagnose_input, load_diagnosis_input
from platform_daemon.features.diagnose.page import diagnosis_html
from tests.kit.html_pages import (
    assert_nothing_is_loaded,
    assert_pictures_speak_and_tables_are_whole,
    elements,
    pictures,
)
from tests.kit.specimen_files import RUNS, THREAD, pendulum, swing


def page_of(specimen):
    found = diagnose_input(specimen, lambda what, share: None)
    report = diagnosis_report(found, files=[str(f) for f in specimen.files])
    return diagnosis_html(report, compare_residuals(found)).decode(), report


@pytest.fixture(scope="module")
def clean():
    return page_of(load_diagnosis_input([THREAD]))


@pytest.mark.long
def test_the_page_is_whole_and_loads_nothing(clean):
    assert_nothing_is_loaded(clean[0])
    assert_pictures_speak_and_tables_are_whole(clean[0])


@pytest.mark.long
def test_every_picture_is_a_png(clean):
    assert pictures(clean[0]) >= 5  # residual of one or two shots, spectra, harmonics, windows, scatter


def test_the_verdict_and_the_numbers_stand_there(clean):
    page, report = clean
    assert "Nothing is missing" in page
    assert f"{report.held_out.chi2_per_dof_after:.4g}" in page
    for heading in ("N50 against D30", "Ranking and evidence", "Integrity of the data", "How it was computed"):
        assert heading in page


@pytest.mark.long
def test_an_angle_with_awkward_name_and_clock_has_its_page_too(tmp_path):
    t, angle = swing()
    t[4000:] += 2 / 400.0
    path = pendulum(tmp_path, t, angle, name="<b>&swing.h5")
    page, _ = page_of(load_diagnosis_input([path], "thread_small_angle"))
    assert "<b>&swing" not in page
    assert "&lt;b&gt;&amp;swing.h5" in page
    assert "clock_gap" in page
    assert any("<b>&swing.h5" in (e.text or "") for e in elements(page) if e.tag == "h1")


@pytest.mark.long
def test_a_constant_that_moves_has_its_picture_before_any_name():
    page, report = page_of(load_diagnosis_input([RUNS[0]]))
    assert [m.name for m in report.where][:1] == ["lambda_per_s"]
    assert (
        page.index("Where something is missing") < page.index("What it is") < page.index("What is left over, in time")
    )
    pictures = [e.get("alt") for e in elements(page) if e.tag == "img"]
    assert pictures[0] == "lambda_per_s along the ring-down"


def test_nothing_is_said_where_no_constant_moves(clean):
    page, report = clean
    assert "Where something is missing" not in page
    assert "where" not in report.model_dump(mode="json")
