"""The operator's page on the emulated lab, whose devices have faults."""

import json
import re
import socket

import pytest
from playwright.sync_api import expect

from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.browser import SLOW_MS, open_view, visit
from tests.kit.command_line import wait_for
from tests.kit.emulator_process import emulator
from tests.kit.rest import finished
from tests.kit.served import ready

pytestmark = pytest.mark.page
expect.set_options(timeout=SLOW_MS)


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    """The daemon of an emulated lab, and what changes its world."""
    folder = tmp_path_factory.mktemp("lab")
    with emulator(folder, "jewel") as (endpoints, said):

        def change(do, **arguments):
            at = said["control"]
            with socket.create_connection((at["host"], at["port"]), 10) as link, link.makefile("rwb") as stream:
                stream.write(json.dumps({"do": do, **arguments}).encode() + b"\n")
                stream.flush()
                answer = json.loads(stream.readline())
            assert answer["ok"], answer

        with ready(folder / "data", "--platform", "emulated", "--endpoints", str(endpoints)) as running:
            yield running, change


@pytest.fixture
def page(chromium, lab):
    visited = visit(chromium, lab[0].address, expected_errors=("Failed to load resource",))
    yield visited.page
    assert visited.errors == []
    visited.context.close()


def test_a_series_of_the_lab_is_seen_and_a_clipped_shot_is_refused_with_its_reason(page, lab):
    daemon, change = lab
    change("inject", kind="adc_clip", shot=1)
    open_view(page, "shot")
    job = daemon.post("/acquisitions", {**SHORT_JEWEL, "shots": 2}).json()["id"]
    assert finished(daemon, f"/acquisitions/{job}")["state"] == "done"
    expect(page.locator(".plot canvas")).to_have_count(3)
    open_view(page, f"series/{job}")
    expect(page.locator(".series")).to_contain_text("1 refused")
    expect(page.locator(".series .bad")).to_have_count(1)
    expect(page.get_by_role("table", name="Newest shots")).to_contain_text("at an end of its range")


def test_an_amplifier_that_has_tripped_is_shown_and_reset(page, lab):
    daemon, change = lab
    change("trip_amplifier")
    open_view(page, "devices")
    expect(page.locator(".devices")).to_contain_text("fault")
    change("repair")
    page.get_by_role("button", name="Reset the power amplifier").click()
    wait_for(lambda: daemon.get("/platform").json()["power_amplifier"]["fault"] is None)
    open_view(page, "now")
    expect(page.locator(".now")).not_to_contain_text("FAULT")


def test_a_link_that_breaks_during_a_series_is_said_with_its_place(page, lab):
    daemon, change = lab
    job = daemon.post("/acquisitions", {**SHORT_JEWEL, "shots": 50}).json()["id"]
    expect(page.locator(".now")).to_contain_text(re.compile(r"shot \d+ of 50"))
    for stream in ("command", "data"):
        change("wire_fault", kind="one_way_link", device="io_card_0", stream=stream)
    assert finished(daemon, f"/acquisitions/{job}")["state"] == "failed"
    expect(page.locator("#standing")).to_contain_text("alarm")
    open_view(page, f"jobs/{job}")
    expect(page.locator(".jobs .bad")).to_contain_text(re.compile(r"I/O card|127\.0\.0\.1:\d+"))
    change("clear_faults")
