"""`python -m tests.page.pictures`: the pictures of docs/howto/page.md, from the simulated platform."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

from tests.kit.browser import visit
from tests.kit.command_line import wait_for
from tests.kit.data import ROOT
from tests.kit.rest import finished
from tests.kit.served import ready

PICTURES = ROOT / "docs" / "pictures"
SIZE = {"width": 1200, "height": 860}
SERIES = {"resonator": "jewel", "sequence": {"rx_s": 3.0}, "sample": "J-01", "operator": "ann"}


def main() -> None:
    """Measure, look, and write the pictures."""
    with tempfile.TemporaryDirectory() as folder, ready(Path(folder) / "data") as daemon, sync_playwright() as p:
        browser = p.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        seen = visit(browser, daemon.address, viewport=SIZE)
        made = finished(daemon, daemon.post("/acquisitions", {**SERIES, "shots": 3}).headers["location"])["id"]
        page = seen.page
        page.goto(f"{daemon.address}/page/#/shot/{made}/0")
        page.get_by_text("Table: Spectrum").wait_for(timeout=120_000)
        page.wait_for_timeout(1000)
        page.screenshot(path=PICTURES / "page-shot.png", full_page=True)
        page.goto(f"{daemon.address}/page/#/start")
        page.locator("#field-resonator").fill("jewel")
        page.locator("#field-shots").fill("20")
        page.get_by_role("button", name="Check (dry run)").click()
        page.get_by_text("What would happen").wait_for(timeout=120_000)
        page.set_viewport_size({**SIZE, "height": 1520})  # *Start* stays at the lower edge of the window
        page.screenshot(path=PICTURES / "page-start.png", full_page=True)
        page.set_viewport_size(SIZE)
        ramp = {"kind": "ramp", "acquisition": {"resonator": "thread_imperfect", "sequence": {"rx_s": 1.0}}}
        daemon.post("/procedures", {**ramp, "start_t": 2.2e-4})
        page.goto(f"{daemon.address}/page/#/ramp")
        page.get_by_role("cell", name="suspected").first.wait_for(timeout=240_000)
        page.screenshot(path=PICTURES / "page-ramp.png", full_page=True)
        phone = visit(browser, daemon.address, "#/shot", viewport={"width": 360, "height": 780}, color_scheme="dark")
        phone.page.get_by_text("Table: Spectrum").wait_for(timeout=120_000)
        phone.page.wait_for_timeout(1000)
        phone.page.screenshot(path=PICTURES / "page-phone.png")
        daemon.stop_all()
        wait_for(lambda: daemon.get("/platform").json()["running"] is None)
        daemon.post("/acquisitions", {**SERIES, "shots": 12})
        page.goto(f"{daemon.address}/page/#/now")
        page.get_by_text("fit of shot 4").wait_for(timeout=120_000)
        page.screenshot(path=PICTURES / "page-now.png", full_page=True)
        browser.close()


if __name__ == "__main__":
    main()
