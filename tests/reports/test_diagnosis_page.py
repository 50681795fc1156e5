"""The page: self-contained, whole, and true to the JSON."""

import base64
import re
from html.parser import HTMLParser

import pytest

from platform_daemon.analysis.diagnose import diagnose_input, load_diagnosis_input
from platform_daemon.diagnosis.report import as_json
from platform_daemon.reports.diagnosis_page import diagnosis_html
from tests.kit.specimen_files import THREAD, pendulum, swing


class Loads(HTMLParser):
    """Everything that a browser would fetch, and the headings."""

    def __init__(self, page):
        super().__init__()
        self.found, self.tags, self.open = [], [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.found += [v for k, v in attrs if k in ("src", "href", "srcset", "data", "action")]
        if tag not in ("meta", "img", "br", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def page_of(specimen):
    found = diagnose_input(specimen, lambda what, share: None)
    report = as_json(found) | {"files": [str(f) for f in specimen.files]}
    return diagnosis_html(found, report).decode(), report


@pytest.fixture(scope="module")
def clean():
    return page_of(load_diagnosis_input([THREAD]))


def test_nothing_is_loaded_from_elsewhere(clean):
    seen = Loads(clean[0])
    assert seen.found
    assert all(source.startswith("data:image/png;base64,") for source in seen.found)
    assert not {"script", "link", "iframe", "object"} & set(seen.tags)
    assert "@import" not in clean[0]
    assert not re.search(r"url\(", clean[0])
    assert seen.open == []


def test_every_picture_is_a_png(clean):
    pictures = re.findall(r"base64,([^\"]+)", clean[0])
    # Residual of one or two shots, spectra, harmonics, windows, scatter.
    assert len(pictures) >= 5
    assert all(base64.b64decode(p).startswith(b"\x89PNG") for p in pictures)


def test_the_verdict_and_the_numbers_stand_there(clean):
    page, report = clean
    assert "Nothing is missing" in page
    assert f"{report['held_out']['chi2_per_dof_after']:.4g}" in page
    for heading in ("N50 against D30", "Ranking and evidence", "Integrity of the data", "How it was computed"):
        assert heading in page


def test_an_angle_with_awkward_name_and_clock_has_its_page_too(tmp_path):
    t, angle = swing()
    t[4000:] += 2 / 400.0
    path = pendulum(tmp_path, t, angle, name="<b>&swing.h5")
    page, _ = page_of(load_diagnosis_input([path], "thread_small_angle"))
    assert "<b>&swing" not in page
    assert "&lt;b&gt;&amp;swing.h5" in page
    assert "clock_gap" in page
