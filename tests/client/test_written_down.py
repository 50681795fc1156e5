"""The script that the client was made for, and the lines of the library, as they were written down before."""

import pytest

from platform_daemon.client import Client
from tests.kit.pages import ROOT
from tests.kit.served import served

MEASURE = """
with Client(URL) as lab:
    job = lab.measure("jewel", shots=20, field_ut=490, window="d30", rx_s=0.6, sample="J-03")
    job.wait(progress=True)
    fits = job.fits()
    wave = job.recording().dmdt(frame=0)
    seen = [event.what.kind for event in lab.events(job)]
"""
PROCEDURES = """
with Client() as lab:
    ramp = lab.ramp("thread_imperfect", start_ut=200, max_ut=300, step_ut=100, rx_s=0.6).wait()
    characterised = lab.characterise("jewel", shots=4, preset="shipped", rx_s=0.6).wait()
    sweep = lab.sweep("thread", over={"field_ut": range(50, 301, 50)}, rx_s=0.6).wait()
    lab.schedules.add("night", measure={"resonator": "jewel", "shots": 2}, every_s=86_400)
    ledger = list(lab.schedules["night"].ledger())
    trend = lab.specimens["J-03"].trend()
    stopped, report = lab.stop(), characterised.report()
"""
LOOP = """
with Client() as lab:
    series = lab.measure("thread", shots=3, rx_s=5.0, pause_s=10.0).wait()
    diagnosis = lab.diagnose(series.recording()).wait()
    adopted = lab.adopt(diagnosis, "draughty", by="DC")
"""
AIR = 'backends.simulated.undeclared=[{id="quadratic_drag", strength=1e-3}]'


@pytest.mark.long
def test_the_script_runs_line_by_line(tmp_path, monkeypatch):
    """What stands there as `...` are arguments that keep it short."""
    with served(tmp_path / "data") as daemon:
        found = {"Client": Client, "URL": daemon.address}
        exec(MEASURE, found)
        assert len(found["fits"]) == 20
        assert found["fits"].attrs["units"]["f_nat_hz"] == "Hz"
        assert {"f_nat_hz", "f_nat_hz_std"} <= set(found["fits"])
        assert found["wave"].dims == ("channel", "time")
        assert {"units", "tx_s", "switch_s", "rx_s"} <= set(found["wave"].attrs)
        assert found["seen"].count("shot") == 20
        monkeypatch.setenv("PLATFORM_DAEMON_URL", daemon.address)
        exec(PROCEDURES, found)
        assert found["ramp"].result.stopped
        assert found["sweep"].steps().field_ut.tolist() == [50, 100, 150, 200, 250, 300]
        assert found["report"].startswith("<!doctype html>")
        assert [row.number for row in found["ledger"]] in ([], [1])  # an interval is due at once, within a second
        assert found["trend"].points
        assert found["stopped"].status


@pytest.mark.long
def test_the_loop_of_diagnosis_and_adoption_runs_line_by_line(tmp_path, monkeypatch):
    with served(tmp_path / "data", "--set", AIR) as daemon:
        monkeypatch.setenv("PLATFORM_DAEMON_URL", daemon.address)
        found = {"Client": Client}
        exec(LOOP, found)
        assert [each.id for each in found["diagnosis"].result.effects] == ["quadratic_drag"]
        assert found["adopted"].label == "draughty@1"


LIBRARY = """
import platform_daemon as pd_

rec = pd_.open("first.h5")
fit = pd_.fit(rec, model="jewel", window="d30")
f_nat_hz, covariance, table, figure = fit["f_nat_hz"].value, fit.covariance, fit.table(), fit.plot()
sim = pd_.simulate("jewel", phi_max_deg=53, seconds=2, noise="paper", seed=1)
report = pd_.diagnose([rec, sim])
report.to_html("r.html")
arrays, frame = rec.to_xarray(), fit.to_dataframe()
own = pd_.from_arrays(sim.time_s(), sim.signal(), noise=(0.014, 0.021, 0.055))
"""


@pytest.mark.long
def test_the_library_runs_line_by_line(tmp_path, monkeypatch):
    (tmp_path / "first.h5").write_bytes((ROOT / "tests/data/example_jewel.mmr.h5").read_bytes())
    monkeypatch.chdir(tmp_path)
    found = {}
    exec(LIBRARY, found)
    assert found["f_nat_hz"] == pytest.approx(213, abs=5)
    assert found["covariance"].shape[0] == len(found["fit"].covariance_names)
    assert "lambda_per_s" in found["table"]
    assert found["report"].report.files[0].endswith("first.h5")
    assert (tmp_path / "r.html").read_text().startswith("<!")
    assert found["arrays"].dims == ("channel", "time")
    assert len(found["frame"]) == 1
