"""What scripts do, on a real daemon."""

import asyncio
import threading
import time

import numpy as np
import pytest

from platform_daemon.client import AsyncClient, Client, Conflict, JobCancelled, NotFound, WaitTimeout
from platform_daemon.core.schemas.jobs import JobState
from tests.kit.acquisitions import SHORT


def test_a_series_brings_a_table_of_fits_with_units(series):
    assert series.state is JobState.DONE
    fits = series.fits()
    assert list(fits.index) == [0, 1]
    assert fits.verdict.tolist() == ["good", "good"]
    assert abs(fits.f_nat_hz - 213.1).max() < 0.2
    assert (fits.f_nat_hz_std > 0).all()
    assert fits.attrs["units"]["m_r_am2_std"] == "A m^2"
    assert set(fits.columns) - {"verdict", "reason"} == set(fits.attrs["units"])


def test_a_frame_is_an_array_with_channels_time_units_and_windows(series):
    wave = series.recording().dmdt(frame=1)
    assert wave.dims == ("channel", "time")
    assert wave.channel.values.tolist() == ["x", "y", "z"]
    assert (wave.attrs["units"], wave.time.attrs["units"]) == ("A m^2/s", "s")
    assert wave.attrs["rx_s"] == pytest.approx(0.6, abs=1e-4)
    part = series.recording().dmdt(frame=1, start_s=0.1, stop_s=0.2)
    assert part.time.values[0] == pytest.approx(0.1, abs=1e-4)
    np.testing.assert_array_equal(part, wave.sel(time=slice(part.time.values[0], part.time.values[-1])))


def test_the_events_of_a_job_begin_with_its_first_and_end_with_its_last(lab, series):
    events = list(lab.events(series))
    assert events[0].what.kind == "job"
    assert events[-1].what.state is JobState.DONE
    shots = [event.what.shot for event in events if event.what.kind == "shot"]
    assert sorted(shots) == [1, 2]
    assert [event.what.kind for event in lab.events(series, kinds=("shot",))] == ["shot", "shot"]
    assert len({event.id for event in events}) == len(events)


def test_lists_are_followed_over_all_pages(lab, series):
    ids = [job.id for job in lab.jobs()]
    assert series.id in ids
    found = {job.id: job for job in lab.jobs_of("acquisition")}
    assert found[series.id].result.recording == series.recording().id
    assert [each.id for each in lab.recordings.list(sample="T-07")] == [series.recording().id]
    assert "T-07" in list(lab.specimens.list())
    assert {"jewel", "thread"} <= {each.id for each in lab.resonators.list()}


def test_a_recording_is_downloaded_as_it_is(lab, series, running, tmp_path):
    path = series.recording().download(tmp_path)
    assert path.name == f"{series.recording().id}.h5"
    assert path.read_bytes() == (running.folder / "recordings" / path.name).read_bytes()
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_a_fit_of_a_recording_and_what_follows_from_it(lab, series):
    fit = lab.fit(series.recording(), window="n50").wait(timeout_s=120)
    assert fit.table().verdict.tolist() == ["good", "good"]
    assert fit.derived().frames[0].quality_factor > 0
    assert fit.envelopes(0, points=20).frame == 0
    budget = fit.budget("m_r_am2")
    assert budget.inputs[0].name == "calibration"
    assert (
        pytest.approx(budget.u**2)
        == dict(zip(budget.covariance.parameters, np.diag(budget.covariance.matrix), strict=True))["m_r_am2"]
    )
    assert series.recording().budget_picture("m_r_am2", window="n50").startswith(b"\x89PNG")
    assert series.recording().info().frames == 2
    second = series.recording().info(first=1, limit=1)
    assert (second.frames, [shot.frame for shot in second.shots]) == (2, [1])
    assert series.recording().info(limit=0).shots == series.recording().info(first=9).shots == ()
    assert series.recording().picture(0).startswith(b"\x89PNG")
    assert len(series.recording().points(0, points=50).t_s) <= 50


def test_a_sweep_has_a_step_for_each_value(lab):
    sweep = lab.sweep("jewel", over={"field_ut": range(400, 501, 100)}, **SHORT).wait(timeout_s=240)
    assert sweep.steps().field_ut.tolist() == [400, 500]
    assert lab.dry_run_procedure("sweep", "jewel", over={"field_ut": np.array([300.0, 400.0])}).shots == 2
    assert lab.dry_run("jewel", shots=7).shots == 7


def test_a_job_that_waits_can_be_edited_ordered_and_cancelled(lab):
    first = lab.measure("jewel", shots=200, pause_s=1.0, **SHORT)
    second = lab.measure("jewel", shots=3, **SHORT)
    second.edit(shots=4, field_ut=400)
    assert (second.view.request.shots, second.view.request.sequence.rx_s) == (4, 0.6)
    third = lab.measure("jewel", **SHORT)
    assert lab.order_queue([third.id]).queued[0] == third.id
    while first.refresh().state is JobState.QUEUED:
        time.sleep(0.05)
    with pytest.raises(Conflict, match="begun"):
        first.edit(shots=2)
    with pytest.raises(WaitTimeout):
        second.wait(timeout_s=0.1)
    for job in (third, second, first):
        job.cancel()
        with pytest.raises(JobCancelled, match=job.id):
            job.wait(timeout_s=30)


def test_a_schedule_is_found_by_its_name(lab):
    work = {"resonator": "jewel", "shots": 2, "field_ut": 400}
    made = lab.schedules.add("night", measure=work, cron="0 22 * * *", time_zone="Europe/Berlin")
    night = lab.schedules["night"]
    assert night.get().id == made.id
    assert made.request.work.request.sequence.field_t == pytest.approx(4e-4)
    assert list(night.ledger()) == []
    assert night.pause().active is False
    assert night.resume().active is True
    assert len(lab.schedules.preview(measure=work, every_s=3600, count=3).due) == 3
    night.remove()
    with pytest.raises(NotFound, match="night"):
        lab.schedules["another night"].get()


def test_the_platform_and_what_else_there_is(lab, series):
    assert lab.health().version
    assert lab.caller().name == "local"
    assert {device.error for device in lab.devices()} == {None}
    assert lab.readiness().ready
    assert lab.specimens["T-07"].trend().specimen == "T-07"
    assert lab.specimens["T-07"].get().recordings == 1
    assert lab.specimens["T-07"].trend_table().splitlines()[0].startswith("at,")
    assert list(lab.alarms()) == []
    assert "# HELP" in lab.metrics()
    assert lab.predict("jewel", phi_max_deg=40).variant == "jewel"
    assert lab.resonators.get("jewel").magnets.radius_m > 0
    assert list(lab.models.list()) == []
    assert lab.stop().status


def test_the_asynchronous_client_does_the_same(running):
    async def script():
        async with AsyncClient(running.address) as lab:
            job = await lab.measure("jewel", **SHORT)
            await job.wait(timeout_s=120)
            kinds = [event.what.kind async for event in lab.events(job)]
            wave = await job.recording().dmdt()
            return await job.fits(), kinds, wave, [each.id async for each in lab.jobs(kind="acquisition")], job

    fits, kinds, wave, ids, job = asyncio.run(script())
    assert len(fits) == 1
    assert kinds[-1] == "job"
    assert wave.dims == ("channel", "time")
    assert job.id in ids


def test_the_address_and_the_token_come_from_the_environment(running, monkeypatch):
    monkeypatch.setenv("PLATFORM_DAEMON_URL", running.address)
    with Client() as lab:
        assert lab.health().status == "ok"


def test_several_threads_share_a_client(lab):
    found = []
    threads = [threading.Thread(target=lambda: found.append(lab.platform())) for _ in range(5)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert len(found) == 5
