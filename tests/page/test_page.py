"""The operator's page on the simulated platform, in a real Chromium."""

import os
import re
import signal
import subprocess
import sys

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect

from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.browser import SLOW_MS, open_view, visit
from tests.kit.command_line import here, wait_for
from tests.kit.data import ROOT
from tests.kit.rest import finished
from tests.kit.served import served

pytestmark = pytest.mark.page
QUICK = pytest.mark.page_quick

VIEWS = (
    *("now", "shot", "series", "start", "jobs", "questions", "alarms", "recordings"),
    *("schedules", "specimens", "ramp", "diagnosis", "devices", "keys"),
)
expect.set_options(timeout=SLOW_MS)


@pytest.fixture(scope="package")
def measured(shared_daemon):
    """Id of a series with two shots."""
    answer = shared_daemon.post("/acquisitions", {**SHORT_JEWEL, "shots": 2, "sample": "J-01"})
    return finished(shared_daemon, answer.headers["location"])["id"]


@QUICK
def test_every_view_opens_without_an_error_and_nothing_comes_from_elsewhere(browse, measured):
    page = browse().page
    expect(page.locator("#fresh")).to_have_text("live")
    for view in VIEWS:
        open_view(page, view)
        expect(page.locator("#view .view > *").first).to_be_visible()
        expect(page.locator("#view .error")).to_have_count(0)


@pytest.mark.parametrize(
    ("width", "scheme"),
    [
        pytest.param(width, scheme, marks=QUICK if (width, scheme) == (320, "dark") else ())
        for width in (320, 768, 1280, 3840)
        for scheme in ("light", "dark")
    ],
)
def test_axe_finds_nothing_and_nothing_overflows(browse, measured, width, scheme):
    page = browse(viewport={"width": width, "height": 900}, color_scheme=scheme).page
    expect(page.locator("#fresh")).to_have_text("live")
    for view in (*VIEWS, "specimens/J-01", f"recordings/{measured}"):
        open_view(page, view)
        expect(page.locator("#view .view > *").first).to_be_visible()
        page.wait_for_timeout(300)
        found = Axe().run(page).response["violations"]
        assert [(each["id"], [n["html"][:120] for n in each["nodes"]]) for each in found] == [], view
        assert page.evaluate("document.documentElement.scrollWidth") <= width, view


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_in_a_page_that_is_old(browse, daemon, scheme):
    page = browse(color_scheme=scheme, expected_errors=("Failed to load",)).page
    expect(page.locator("#fresh")).to_have_text("live")
    open_view(page, "start")
    expect(page.locator("#view .view > *").first).to_be_visible()
    daemon.kill("web", signal.SIGSTOP)
    try:
        expect(page.locator("body.old")).to_be_visible()
        found = Axe().run(page).response["violations"]
    finally:
        daemon.kill("web", signal.SIGCONT)
    assert [each["id"] for each in found] == []


@QUICK
def test_a_shot_is_drawn_with_its_parameters_and_a_zoom_loads_samples(browse, measured):
    visited = browse()
    open_view(visited.page, f"shot/{measured}/0")
    expect(visited.page.locator(".plot canvas")).to_have_count(3)
    expect(visited.page.locator("table", has_text="f_nat")).to_contain_text(re.compile(r"213\.\d+\(\d+\)"))
    visited.page.get_by_role("button", name="First 25 ms").click()
    expect(visited.page.get_by_text("Samples and fit").first).to_be_attached()
    assert any("dmdt.f32" in url and "stop_s=0.025" in url for url in visited.requests)
    visited.page.locator(".plot").first.focus()
    visited.page.keyboard.press("ArrowRight")
    expect(visited.page.locator(".readout").first).to_contain_text("fit x")


def test_a_ramp_shows_where_it_goes_next_and_why_and_the_end(browse, daemon):
    request = {"kind": "ramp", "acquisition": {"resonator": "thread_imperfect", "sequence": {"rx_s": 1.0}}}
    job = daemon.post("/procedures", {**request, "start_t": 1.1e-4, "max_t": 1.4e-4}).headers["location"]
    page = browse().page
    expect(page.locator(".now")).to_contain_text("amp of thread_imperfect")
    page.get_by_role("link", name=re.compile(r"^step \d")).click()
    expect(page.locator(".ramp")).to_contain_text(re.compile(r"Next field\s*1[1-4]0\sµT: .*with a chance of"))
    expect(page.locator(".ramp")).to_contain_text("Threshold, so far")
    expect(page.locator(".plot canvas")).to_have_count(3)
    assert finished(daemon, job)["state"] == "done"
    expect(page.locator(".ramp")).to_contain_text("the highest field that was requested")
    expect(page.locator(".ramp")).not_to_contain_text("Next field")
    page.get_by_text("Table: Posterior of the threshold").click()
    expect(page.get_by_role("table", name="Posterior of the threshold")).to_contain_text("µT")


@QUICK
def test_a_ramp_is_planned_in_microtesla_and_the_next_view_begins_at_its_top(browse):
    page = browse().page
    open_view(page, "start/ramp")
    expect(page.locator(".field", has=page.locator("#field-step_t"))).to_contain_text("= 10\u00a0µT")
    page.locator("#field-acquisition-resonator").fill("thread_imperfect")
    page.get_by_role("button", name="Check (dry run)").click()
    expect(page.get_by_role("table", name="Steps")).to_contain_text(re.compile(r"field 1\d\d µT"))
    page.evaluate("scrollTo(0, document.body.scrollHeight)")
    open_view(page, "now")
    expect(page.locator(".now")).to_contain_text("Devices")
    assert page.evaluate("scrollY") == 0


def test_a_metrologist_comes_from_a_specimen_to_its_recordings_and_sees_the_temperature(browse, measured):
    page = browse().page
    open_view(page, "specimens/J-01")
    page.locator(".specimens dd a").click()
    page.get_by_role("link", name=measured).click()
    expect(page.get_by_role("table", name="Frames")).to_contain_text("°C")
    page.get_by_role("link", name="Parameters by shot").click()
    expect(page.get_by_role("img", name="temperature / °C by shot")).to_be_visible()


def test_back_from_two_recordings_that_are_compared_the_search_and_the_choice_are_there_again(browse, daemon, measured):
    finished(daemon, daemon.post("/acquisitions", {**SHORT_JEWEL, "sample": "J-01"}).headers["location"])
    page = browse().page
    open_view(page, "recordings")
    page.get_by_label("Specimen").fill("J-01")
    with page.expect_response(re.compile("specimen=J-01")):
        page.get_by_role("button", name="Search").click()
    for k in range(2):
        page.get_by_role("checkbox").nth(k).check()
    page.get_by_role("link", name="Compare the two").click()
    expect(page.get_by_role("table", name="First good shot of each")).to_be_visible()
    page.go_back()
    expect(page.get_by_label("Specimen")).to_have_value("J-01")
    expect(page.get_by_role("checkbox", checked=True)).to_have_count(2)


def test_the_budget_of_a_recording_says_what_contributes_and_what_nobody_has_declared(browse, daemon, measured):
    told = daemon.get(f"/recordings/{measured}/budget", params={"quantity": "m_r_am2"}).json()
    page = browse().page
    open_view(page, f"recordings/{measured}")
    page.get_by_label("Uncertainty of").select_option("m_r_am2")
    page.get_by_role("button", name="Show the budget").click()
    rows = page.get_by_role("table", name="What contributes").locator("tbody tr")
    large = [line for line in told["inputs"] if line["contribution"] >= 0.01 * told["u"]]
    expect(rows).to_have_count(len(large))
    expect(rows.first).to_contain_text(large[0]["name"])
    assert float(rows.first.locator("meter").get_attribute("max")) == pytest.approx(told["u"])
    assert rows.first.locator("meter").evaluate("each => each.value") == pytest.approx(large[0]["contribution"])
    expect(page.get_by_role("table", name="Not declared")).to_contain_text(told["not_declared"][0]["name"])
    assert Axe().run(page).response["violations"] == []


@QUICK
def test_a_series_is_started_by_keys_alone_after_its_dry_run(browse, daemon):
    visited = browse()
    page = visited.page
    expect(page.locator("#fresh")).to_have_text("live")
    page.keyboard.press("m")
    page.locator("#field-resonator").focus()
    page.keyboard.type("jewel")
    page.keyboard.press("Tab")
    page.keyboard.type("30")
    page.keyboard.press("Enter")
    expect(page.get_by_text("What would happen")).to_be_visible()
    expect(page.locator(".start .card")).to_contain_text("MB")
    assert daemon.get("/platform").json()["running"] is None
    start = page.get_by_role("button", name="Start", exact=True)
    start.focus()
    page.keyboard.press("Enter")
    expect(page.get_by_text("Accepted")).to_be_visible()
    assert len([url for _, url in visited.sent if url.endswith("/acquisitions")]) == 1
    page.locator("body").press("n")
    expect(page.locator(".now")).to_contain_text(re.compile(r"shot \d+ of 30"))


@QUICK
def test_on_a_phone_the_dry_run_and_the_actions_of_the_queue_are_on_the_screen(browse, daemon):
    page = browse(viewport={"width": 320, "height": 640}).page
    open_view(page, "start")
    page.locator("#field-resonator").fill("jewel")
    page.locator("#field-shots").fill("200")
    page.get_by_role("button", name="Check (dry run)").click()
    expect(page.get_by_role("heading", name="What would happen")).to_be_focused()
    expect(page.get_by_text("Peak field")).to_be_in_viewport()
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.get_by_text("Accepted")).to_be_visible()
    open_view(page, "jobs")
    cancel = page.get_by_role("button", name="Cancel").first
    box = cancel.evaluate("button => { button.scrollIntoView(); return button.getBoundingClientRect().toJSON() }")
    assert box["left"] >= 0
    assert box["right"] <= 320
    assert page.locator(".stacks").first.evaluate("box => box.scrollWidth <= box.clientWidth")


def test_what_is_typed_opened_and_selected_stays_while_lists_change_beside_it(browse, daemon):
    page = browse().page
    running, waiting = (daemon.post("/acquisitions", {**SHORT_JEWEL, "shots": 500}).json()["id"] for _ in "ab")
    wait_for(lambda: daemon.get("/platform").json()["running"] == running)
    open_view(page, "jobs")
    queue = page.get_by_role("table", name="What runs and what waits")
    row = queue.locator(f"tr[data-key='#/jobs/{waiting}']")
    priority = row.get_by_role("spinbutton")
    priority.press("End")
    priority.press_sequentially("7")
    newest = daemon.post("/acquisitions", SHORT_JEWEL).json()["id"]
    expect(page.locator(f"tr[data-key='#/jobs/{newest}']")).to_have_count(2)
    expect(queue).to_contain_text(re.compile(r"shot ([3-9]|\d\d+): .*, [1-9]"))  # the progress goes on, too
    expect(priority).to_be_focused()
    priority.press_sequentially("1")
    priority.press("Enter")
    wait_for(lambda: daemon.get(f"/acquisitions/{waiting}").json()["request"].get("priority") == 71)
    later = row.get_by_role("button", name="Later")
    later.focus()
    page.keyboard.press("Enter")
    expect(row.get_by_role("button", name="Earlier")).to_be_visible()
    open_view(page, f"jobs/{running}")
    page.get_by_text("What was asked for").click()
    page.locator(".jobs dd", has_text=running).first.select_text()
    fraction = page.locator(".jobs dl").inner_text()
    expect(page.locator(".jobs dl")).not_to_have_text(fraction)
    assert page.locator(".jobs details").get_attribute("open") is not None
    assert page.evaluate("getSelection().toString()") == running
    for job in (waiting, running):
        daemon.delete(f"/acquisitions/{job}")


@QUICK
def test_a_button_that_is_pressed_while_its_list_changes_gets_its_click(browse, daemon):
    page = browse().page
    before, running = (
        daemon.post("/acquisitions", {"resonator": "jewel", "shots": 200}).json()["id"] for _ in range(2)
    )
    open_view(page, f"jobs/{running}")
    cancel = page.get_by_role("button", name="Cancel")
    cancel.hover()
    daemon.delete(f"/acquisitions/{before}")
    # Rows that come with the first shot do not move the button away from the pointer.
    expect(page.locator("#view dl").get_by_text("shots", exact=True)).to_be_visible()
    page.mouse.down()
    with page.expect_response(lambda answer: answer.url.endswith(f"/{running}")):
        daemon.post("/platform/queue", {"priority": {running: 5}})
    page.mouse.up()
    expect(page.locator("#view")).to_contain_text("cancelled")


@QUICK
def test_a_schedule_says_its_cron_expression_in_words(browse, daemon):
    work = {"kind": "acquisition", "request": {"resonator": "jewel", "shots": 1}}
    trigger = {"cron": "0 22 * * 1-5", "time_zone": "Europe/Berlin"}
    made = daemon.post("/schedules", {"name": "nightly", "trigger": trigger, "work": work}).json()
    page = browse().page
    open_view(page, "schedules")
    words = "At 22:00 on Monday through Friday, Europe/Berlin (cron: 0 22 * * 1-5)"
    expect(page.get_by_role("cell", name=words)).to_be_visible()
    daemon.delete(f"/schedules/{made['id']}")


@QUICK
def test_escape_twice_stops_by_the_port_that_only_stops(browse, daemon):
    visited = browse()
    expect(visited.page.locator("#fresh")).to_have_text("live")
    job = daemon.post("/acquisitions", {"resonator": "jewel", "shots": 100}).json()["id"]
    wait_for(lambda: daemon.get("/platform").json()["running"] == job)
    visited.page.keyboard.press("Escape")
    visited.page.keyboard.press("Escape")
    expect(visited.page.locator("#stopped")).to_contain_text("Outputs are off, proved at")
    assert visited.sent == [("POST", daemon.stop)]
    assert finished(daemon, f"/acquisitions/{job}")["state"] == "cancelled"


@QUICK
def test_what_is_refused_is_said_at_its_field_and_nothing_moves(browse, daemon):
    page = browse(expected_errors=("422",)).page
    open_view(page, "start")
    page.locator("#field-resonator").fill("thread")
    page.locator(".start details summary").first.click()
    page.get_by_text("sequence: settings").click()
    page.locator("#field-sequence-field_t").fill("0.5")
    page.get_by_role("button", name="Check (dry run)").click()
    expect(page.locator("#field-sequence-field_t-note")).to_contain_text("limits.max_field_t")
    expect(page.locator("#field-sequence-field_t")).to_have_attribute("aria-invalid", "true")
    expect(page.get_by_role("button", name="Start", exact=True)).to_be_disabled()


@QUICK
def test_a_double_click_sends_once(browse, daemon):
    visited = browse()
    open_view(visited.page, "start/self-test")
    visited.page.get_by_role("button", name="Start", exact=True).dblclick()
    expect(visited.page.get_by_text("Accepted")).to_be_visible()
    assert len([url for _, url in visited.sent if url.endswith("/self-tests")]) == 1


@QUICK
def test_all_tabs_of_a_browser_share_one_stream_of_events(browse):
    visited = browse()
    expect(visited.page.locator("#fresh")).to_have_text("live")
    others = [visited.context.new_page() for _ in range(3)]
    for tab in others:
        tab.goto(visited.page.url)
        expect(tab.locator("#fresh")).to_have_text("live")
        expect(tab.locator(".now")).to_contain_text("Devices")
    assert len([url for url in visited.requests if url.endswith("/events")]) == 1


@QUICK
def test_a_daemon_that_is_halted_is_seen_and_one_that_answers_again_too(browse, daemon):
    page = browse(expected_errors=("Failed to load",)).page
    expect(page.locator("#fresh")).to_have_text("live")
    pid = daemon.kill("web", signal.SIGSTOP)
    try:
        expect(page.locator("#fresh")).to_contain_text("OLD")
        expect(page.locator("#standing")).to_contain_text("does not answer")
    finally:
        daemon.kill("web", signal.SIGCONT)
    assert pid is not None
    expect(page.locator("#fresh")).to_have_text("live")


def test_a_token_is_asked_for_once_and_its_role_decides(chromium, tmp_path):
    data = tmp_path / "data"
    token = here("token", "add", "eva", "--role", "viewer", "--data", data).stdout.strip()
    with served(data) as running:
        visited = visit(chromium, running.address, expected_errors=("401",))
        try:
            page = visited.page
            page.get_by_label("Token", exact=True).last.fill("wrong")
            page.get_by_role("button", name="Go on").click()
            expect(page.locator("dialog .inline-error")).to_contain_text("not valid")
            page.locator("#token").fill(token)
            page.get_by_role("button", name="Go on").click()
            expect(page.locator("footer")).to_contain_text("eva (viewer)")
            open_view(page, "start")
            expect(page.get_by_role("button", name="Check (dry run)")).to_be_disabled()
            page.get_by_role("button", name="STOP").click()
            expect(page.locator("#stopped")).to_contain_text("Outputs are off")
            here("token", "revoke", "eva", "--data", data)
            expect(page.locator("dialog")).to_be_visible()
            assert visited.errors == []
        finally:
            visited.context.close()


def test_the_wall_shows_and_changes_nothing(browse, measured):
    page = browse(path="?wall").page
    expect(page.locator("#fresh")).to_have_text("live")
    expect(page.locator("nav")).to_be_hidden()
    expect(page.get_by_role("button", name="STOP")).to_be_visible()
    expect(page.locator("#nav a[aria-current=page]")).to_have_attribute("href", "#/shot")


@pytest.mark.parametrize(("path", "word"), [(None, "page.png"), ("/nowhere", "no browser was found")])
def test_the_demo_leaves_a_picture_of_the_page_or_says_that_there_is_no_browser(daemon, measured, tmp_path, path, word):
    call = f"import run, pathlib; run.HERE = pathlib.Path('{tmp_path}'); run.keep_picture_of_page('{daemon.address}')"
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "demo"), **({"PATH": path} if path else {})}
    done = subprocess.run([sys.executable, "-c", call], capture_output=True, text=True, env=environment, check=True)
    assert word in done.stdout + " ".join(each.name for each in tmp_path.iterdir())


def test_a_browser_is_led_from_the_address_of_the_daemon_to_the_page(browse, daemon):
    page = browse().page
    page.goto(daemon.address)
    expect(page).to_have_url(f"{daemon.address}/page/")
    assert daemon.get("/").json()["name"] == "platform-daemon"
