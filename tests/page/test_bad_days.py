"""Bad days: what the page says when something dies, goes away, changes behind it, or is refused."""

import os
import re
import signal
from urllib.parse import urlsplit

import httpx2
import pytest
from playwright.sync_api import expect

from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.browser import SLOW_MS, open_view, visit
from tests.kit.command_line import here, wait_for
from tests.kit.rest import finished
from tests.kit.served import served

pytestmark = pytest.mark.page

expect.set_options(timeout=SLOW_MS)
LONG_SERIES = {**SHORT_JEWEL, "shots": 5000, "window": None}
LOST = ("Failed to load resource", "ERR_")  # the browser's own words for an answer that is an error, or none


def test_a_daemon_that_was_killed_and_started_again_is_read_again_by_the_page_that_is_open(chromium, tmp_path):
    data = tmp_path / "data"
    with served(data) as running:
        visited = visit(chromium, running.address, "#/jobs", expected_errors=LOST)
        page = visited.page
        running.post("/acquisitions", LONG_SERIES)
        expect(page.locator(".jobs")).to_contain_text("running")
        os.kill(running.process.pid, signal.SIGKILL)
        expect(page.locator("#fresh")).to_contain_text("OLD")
        expect(page.locator("#standing")).to_contain_text("does not answer")
        expect(page.locator(".jobs")).to_contain_text("running")  # what was read last stays
    with served(data, "--port", str(urlsplit(running.address).port)):
        expect(page.locator("#fresh")).to_have_text("live")
        expect(page.locator(".jobs")).to_contain_text("the daemon ended while this acquisition was running")
        page.get_by_role("button", name="STOP").click()
        expect(page.locator("#stopped")).to_contain_text("Outputs are off")
    assert [method for method, _ in visited.sent if method != "POST"] == []
    assert visited.errors == []
    visited.context.close()


def test_a_series_goes_on_while_the_web_process_is_dead_and_the_page_finds_it_again(browse, daemon):
    visited = browse(expected_errors=LOST)
    page = visited.page
    job = daemon.post("/acquisitions", LONG_SERIES).json()["id"]
    expect(page.locator(".now")).to_contain_text(re.compile(r"shot \d+ of 5000"))

    def shown():
        found = re.search(r"shot (\d+) of 5000", page.locator(".now").inner_text())
        return 0 if found is None else int(found[1])

    seen = shown()
    daemon.kill("web")
    wait_for(lambda: daemon.pid("web") is not None)
    wait_for(lambda: shown() > seen + 2)
    expect(page.locator("#fresh")).to_have_text("live")
    assert daemon.get("/platform").json()["running"] == job
    assert visited.sent == []


def test_a_recording_that_was_deleted_behind_the_page_is_said_to_be_missing(browse, daemon):
    job = finished(daemon, daemon.post("/acquisitions", SHORT_JEWEL).headers["location"])
    page = browse(expected_errors=("404",)).page
    open_view(page, "recordings")
    link = page.get_by_role("link", name=job["id"])
    expect(link).to_be_visible()
    (file,) = (daemon.folder / "recordings").rglob(f"{job['id']}*.h5")
    file.unlink()
    link.click()
    expect(page.locator("#view .error")).to_contain_text(job["id"])
    page.get_by_role("link", name="See what is there").click()
    expect(page.locator(".recordings")).to_contain_text("Compare")
    expect(page.get_by_role("link", name=job["id"])).to_have_count(0)
    open_view(page, f"shot/{job['id']}/0")
    expect(page.locator("#view")).to_contain_text("It may have been deleted")


def test_refused_shots_a_failed_series_and_a_failed_diagnosis_say_why(chromium, tmp_path):
    with served(tmp_path / "data", "--set", "backends.simulated.lna.overload_v=1e-9") as running:
        visited = visit(chromium, running.address, "#/shot", expected_errors=LOST)
        page = visited.page
        job = finished(running, running.post("/acquisitions", {**SHORT_JEWEL, "shots": 5}).headers["location"])["id"]
        expect(page.locator(".shot")).to_contain_text("This shot was refused: ")
        open_view(page, "now")
        expect(page.locator(".now")).to_contain_text("refused")
        expect(page.locator("#standing")).to_contain_text("alarm")
        open_view(page, f"jobs/{job}")
        expect(page.locator(".jobs .bad")).to_contain_text("refused")
        open_view(page, "alarms")
        page.get_by_label("My name").fill("ann")
        page.get_by_role("button", name="Acknowledge shots").click()
        expect(page.locator(".alarms tr", has_text="shots were refused")).to_contain_text("ann")
        open_view(page, f"start/diagnose/{job}")
        page.get_by_role("button", name="Start", exact=True).click()
        expect(page.get_by_text("Accepted")).to_be_visible()
        page.locator(".start .good a").first.click()
        expect(page.locator(".jobs .bad")).not_to_be_empty()
        open_view(page, "diagnosis")
        expect(page.locator(".diagnosis")).to_contain_text("failed")
        assert visited.errors == []
        visited.context.close()


def test_limits_that_change_while_a_form_is_open_are_said_at_its_field(browse, daemon):
    thread = daemon.get("/resonators/thread").json()
    found = {"max_field_t": 1e-4, "operating_field_t": 8e-5, "found": "2026-11-01T00:00:00Z", "evidence": "a ramp"}
    daemon.post("/resonators?name=mine", thread)
    visited = browse(expected_errors=("422",))
    page = visited.page
    open_view(page, "start")
    page.locator("#field-resonator").fill("mine")
    page.get_by_role("button", name="Check (dry run)").click()
    start = page.get_by_role("button", name="Start", exact=True)
    expect(start).to_be_enabled()
    assert daemon.post("/resonators?name=mine", {**thread, "side_modes": found}).status_code == 201
    start.click()
    expect(page.locator("#view .error")).to_contain_text("shows side modes")
    expect(page.locator("#field-resonator")).to_have_value("mine")
    assert daemon.get("/platform").json()["running"] is None


def test_two_people_see_who_has_stopped_and_what_the_other_has_changed(chromium, tmp_path):
    data = tmp_path / "data"
    names = ("ann", "bob")
    tokens = {name: here("token", "add", name, "--role", "operator", "--data", data).stdout.strip() for name in names}
    with served(data) as running:
        visits = {name: visit(chromium, running.address, expected_errors=("401",)) for name in names}
        for name, visited in visits.items():
            visited.page.locator("#token").fill(tokens[name])
            visited.page.get_by_role("button", name="Go on").click()
            expect(visited.page.locator("footer")).to_contain_text(f"{name} (operator)")
        ann, bob = (visits[name].page for name in names)
        open_view(ann, "start")
        ann.locator("#field-resonator").fill("jewel")
        ann.locator("#field-shots").fill("5000")
        ann.get_by_role("button", name="Check (dry run)").click()
        ann.get_by_role("button", name="Start", exact=True).click()
        expect(bob.locator(".now")).to_contain_text("of 5000")
        expect(bob.get_by_role("row", name="ann at 127.0.0.1").first).to_contain_text("start acquisition")
        asked = {"headers": {"Authorization": f"Bearer {tokens['ann']}"}, "json": SHORT_JEWEL}
        waiting = httpx2.post(f"{running.address}/acquisitions", **asked).json()["id"]
        open_view(bob, f"start/edit/{waiting}")
        bob.locator("#field-shots").fill("7")
        bob.get_by_role("button", name="Check (dry run)").click()
        bob.get_by_role("button", name="Change the job").click()
        expect(bob.get_by_text("Changed: ")).to_be_visible()
        open_view(ann, "now")
        expect(ann.get_by_role("row", name="bob at 127.0.0.1").first).to_contain_text("edit acquisition")
        bob.keyboard.press("Escape")
        bob.keyboard.press("Escape")
        expect(bob.locator("#stopped.good")).to_be_visible()
        open_view(ann, "now")
        expect(ann.locator(".now")).to_contain_text("No job runs")
        expect(ann.get_by_role("row", name="bob at 127.0.0.1").first).to_contain_text("stop")
        open_view(bob, "start")
        bob.locator("#field-comment").fill("half written")
        here("token", "revoke", "bob", "--data", data)
        bob.locator("#token").fill(here("token", "add", "rob", "--role", "operator", "--data", data).stdout.strip())
        bob.get_by_role("button", name="Go on").click()
        expect(bob.locator("footer")).to_contain_text("rob (operator)")
        expect(bob.locator("#field-comment")).to_have_value("half written")
        for visited in visits.values():
            assert visited.errors == []
            visited.context.close()


def test_a_reload_and_a_step_back_send_nothing_again(browse, daemon):
    visited = browse()
    page = visited.page
    open_view(page, "start/self-test")
    page.get_by_role("button", name="Start", exact=True).click()
    expect(page.get_by_text("Accepted")).to_be_visible()
    page.reload()
    expect(page.get_by_role("button", name="Start", exact=True)).to_be_enabled()
    open_view(page, "jobs")
    page.go_back()
    expect(page.get_by_role("button", name="Start", exact=True)).to_be_enabled()
    assert len(visited.sent) == 1


def test_a_start_whose_answer_was_lost_leads_to_the_job_that_has_begun(browse, daemon):
    def lose(route):
        asked.append(route.fetch().json()["id"])
        route.abort()

    asked = []
    page = browse(expected_errors=LOST).page
    open_view(page, "start/self-test")
    page.route("**/self-tests", lose, times=1)
    start = page.get_by_role("button", name="Start", exact=True)
    start.click()
    expect(page.locator(".start .error")).to_contain_text("does not answer")
    start.click()
    expect(page.get_by_role("link", name=asked[0])).to_be_visible()


def test_a_button_that_is_pressed_twice_does_no_second_thing(browse, daemon):
    page = browse().page
    open_view(page, "schedules")
    page.get_by_text("Add a schedule of a series").click()
    page.get_by_label("Name", exact=True).fill("once")
    page.get_by_label("Sample", exact=True).fill("J-01")
    add = page.get_by_role("button", name="Add the schedule")
    add.click()
    expect(page.get_by_text("The schedule is active.")).to_be_visible()
    add.click()
    row = page.locator(".schedules tr", has=page.get_by_role("link", name="once", exact=True))
    row.get_by_role("button", name="Pause").click()
    row.get_by_role("button", name="Resume").hover()
    page.mouse.down(click_count=2)  # of a double click, after the first has made Resume of Pause
    page.mouse.up(click_count=2)
    page.reload()
    expect(row).to_contain_text("off")
    (made,) = (each for each in daemon.get("/schedules").json()["items"] if each["request"]["name"] == "once")
    daemon.delete(f"/schedules/{made['id']}")


def test_a_tab_that_is_hidden_gives_the_stream_away_and_is_right_when_it_is_shown_again(browse, daemon):
    visited = browse()
    first = visited.page
    expect(first.locator("#fresh")).to_have_text("live")
    other = visited.context.new_page()
    other.goto(first.url)
    expect(other.locator("#fresh")).to_have_text("live")
    with other.expect_request(re.compile("/events$")):
        hide(first, hidden=True)
    expect(other.locator("#fresh")).to_have_text("live")
    job = daemon.post("/acquisitions", LONG_SERIES).json()["id"]
    expect(other.locator(".now")).to_contain_text("of 5000")
    hide(first, hidden=False)
    expect(first.locator(".now")).to_contain_text("of 5000")
    assert daemon.get("/platform").json()["running"] == job


def hide(page, *, hidden):
    """What a browser does when another tab is chosen: a headless one never hides a tab by itself."""
    page.evaluate(
        """hidden => {
          Object.defineProperty(document, 'hidden', {configurable: true, get: () => hidden});
          document.dispatchEvent(new Event('visibilitychange'));
        }""",
        hidden,
    )


def test_a_clock_that_is_wrong_is_said_and_does_no_harm(browse, daemon):
    visited = browse()
    page = visited.page
    page.clock.set_system_time("2020-01-01T00:00:00Z")
    expect(page.locator("#standing")).to_contain_text("The clock of this device is")
    expect(page.locator("#fresh")).to_have_text("live")


def test_a_page_whose_first_answers_fail_says_so_and_begins_when_they_come(browse, daemon):
    page = browse(expected_errors=LOST).page
    for path in ("**/parameters.json", "**/caller"):
        page.route(path, lambda route: route.abort())
    page.reload()
    expect(page.locator("#view .error")).to_contain_text("The daemon does not answer")
    page.unroute_all()
    expect(page.locator(".now")).to_contain_text("Devices")
    open_view(page, "start")
    expect(page.get_by_role("button", name="Check (dry run)")).to_be_enabled()


def test_a_browser_that_keeps_nothing_shows_the_platform_and_starts_work(browse, daemon):
    page = browse().page
    page.add_init_script(
        """for (const name of ['sessionStorage', 'localStorage'])
             Object.defineProperty(window, name, {get() { throw new DOMException('denied', 'SecurityError'); }});"""
    )
    page.reload()
    expect(page.locator("#fresh")).to_have_text("live")
    open_view(page, "alarms")
    expect(page.locator(".alarms")).to_contain_text("Active alarms")


def test_what_answers_in_place_of_the_daemon_or_is_of_another_version_is_said_with_the_remedy(browse, daemon):
    page = browse(expected_errors=("404",)).page
    page.route("**/platform", lambda route: route.fulfill(body="<html>sign in</html>", content_type="text/html"))
    expect(page.locator("#standing")).to_contain_text("Something else than the daemon answers")
    expect(page.locator("#fresh")).to_contain_text("OLD")
    page.unroute_all()
    expect(page.locator("#fresh")).to_have_text("live")
    other = "import { nothing } from '../dom.js'; export { nothing as show };"
    page.route("**/views/devices.js", lambda route: route.fulfill(body=other, content_type="text/javascript"))
    open_view(page, "devices")
    expect(page.locator("#view .error")).to_contain_text("Remedy: reload the page")
    open_view(page, "shot/%E0%A4%A/0")
    expect(page.locator("#view .error")).to_contain_text("%E0%A4%A")


def test_outputs_are_said_to_be_off_until_the_next_job_begins(browse, daemon):
    page = browse().page
    expect(page.locator("#fresh")).to_have_text("live")
    page.get_by_role("button", name="STOP").click()
    expect(page.locator("#stopped")).to_contain_text("Outputs are off")
    daemon.post("/acquisitions", SHORT_JEWEL)
    expect(page.locator("#stopped")).to_be_hidden()
