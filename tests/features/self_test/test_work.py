"""The self-test before a series, on a platform that is wired wrongly on purpose."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from drivers.errors import SequenceRejected
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.submit_options import SUBMIT_NOW, SubmitOptions
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import SelfTestOptions
from platform_daemon.core.service.bench import Folders, HardwareBench
from platform_daemon.features.self_test.schema import SelfTestRequest
from platform_daemon.features.self_test.work import SelfTest, SelfTestFailed, SelfTestJob, plan
from tests.kit.acquisitions import acquire

ON = "self_test.enabled=true"
WIRING = "backends.simulated.wiring"


@pytest.fixture
def tested(engine_with: Callable[..., Engine]) -> Callable[..., dict[str, Any] | None]:
    """Runs the self-test of a platform with overrides and options."""

    def run(*overrides: str, **options: Any) -> dict[str, Any] | None:
        engine = engine_with(*overrides)
        asked = SelfTestOptions(**{"enabled": True, "isolation_db": 80.0, **options})
        report = SelfTest(engine.platform, engine.side, asked)()
        assert engine.platform.backends["simulated"].world.violations() == ()  # type: ignore[attr-defined]
        return report

    return run


class TestRightWiring:
    @pytest.mark.parametrize("isolation_db", [80.0, None])
    @pytest.mark.parametrize("seed", range(5))
    def test_passes_and_says_what_it_heard(
        self, tested: Callable[..., dict[str, Any]], isolation_db: float | None, seed: int
    ) -> None:
        report = tested(f"backends.simulated.seed={seed}", isolation_db=isolation_db)
        assert all(abs(gain - 1) < 0.3 for gain in report.gain.values())
        assert all(abs(db - 80) < 3 for db in report.isolation_db.values())

    def test_passes_with_a_receive_chain_that_delays_and_an_inverted_channel_that_the_calibration_knows(
        self, engine_with: Callable[..., Engine]
    ) -> None:
        engine = engine_with('backends.simulated.receive.chain="non_ideal"')
        assert SelfTest(engine.platform, engine.side, SelfTestOptions(enabled=True, isolation_db=80.0))() is not None

    def test_hardly_moves_a_resonator(self, engine_with: Callable[..., Engine], tmp_path: Path) -> None:
        quiet = ("backends.simulated.noise.scale=0.05", "backends.simulated.effects.friction_scatter.enabled=false")
        deflections = []
        for test in ("true", "false"):
            job = acquire(engine_with(f"self_test.enabled={test}", *quiet), tmp_path / f"{test}.h5")
            assert job.error is None
            deflections.append(job.result.fit.frames[0].parameters["phi_max_rad"].value)
        assert deflections[0] == pytest.approx(deflections[1], abs=2e-3)


class TestWrongWiring:
    @pytest.mark.parametrize("isolation_db", [80.0, None])
    @pytest.mark.parametrize(
        ("wiring", "said"),
        [
            ("outputs=[0, 2, 1]", "coil y is connected to output 2, which is that of coil z"),
            ("outputs=[1, 0, 2]", "coil x is connected to output 1, which is that of coil y"),
            ("outputs=[1, 2, 0]", "coil z is connected to output 0, which is that of coil x"),
            ("factors=[-1.0, 1.0, 1.0]", "the polarity of x is inverted"),
            ("factors=[1.0, 1.0, -1.0]", "the polarity of z is inverted"),
            ("factors=[1.0, 1.0, 0.5]", "the gain of z is 0."),
            ("factors=[1.0, 2.0, 1.0]", "the gain of y is 2"),
            ("factors=[1.0, 0.0, 1.0]", "nothing is heard of output 1: cable of coil y open"),
        ],
    )
    def test_is_refused_in_words(
        self, tested: Callable[..., Any], wiring: str, said: str, isolation_db: float | None
    ) -> None:
        with pytest.raises(SelfTestFailed) as refused:
            tested(f"{WIRING}.{wiring}", isolation_db=isolation_db)
        assert said in str(refused.value)

    def test_names_only_what_is_wrong(self, tested: Callable[..., Any]) -> None:
        with pytest.raises(SelfTestFailed) as refused:
            tested(f"{WIRING}.factors=[1.0, -1.0, 1.0]")
        assert refused.value.why == "the polarity of y is inverted"

    def test_two_faults_at_once_are_both_named(self, tested: Callable[..., Any]) -> None:
        with pytest.raises(SelfTestFailed) as refused:
            tested(f"{WIRING}.outputs=[0, 2, 1]", f"{WIRING}.factors=[-1.0, 1.0, 1.0]")
        assert "polarity of x is inverted" in refused.value.why
        assert "coil y is connected to output 2" in refused.value.why

    def test_a_wrong_gain_of_the_whole_chain_shows_if_the_isolation_is_declared(
        self, tested: Callable[..., Any]
    ) -> None:
        with pytest.raises(SelfTestFailed, match=r"the gain of x is 0\.5"):
            tested(f"{WIRING}.factors=[0.5, 0.5, 0.5]")

    def test_a_stuck_switch_is_named(self, tested: Callable[..., Any]) -> None:
        with pytest.raises(SelfTestFailed, match="the Tx/Rx switch is stuck"):
            tested("backends.simulated.faults.switch_stuck=[1]")

    def test_a_receiver_that_hears_too_much_is_a_connected_one(self, tested: Callable[..., Any]) -> None:
        with pytest.raises(SelfTestFailed, match="stuck on receive"):
            tested("backends.simulated.switch.isolation_db=50.0")

    def test_a_tone_lost_in_noise_proves_nothing(self, tested: Callable[..., Any]) -> None:
        with pytest.raises(SelfTestFailed, match=r"raise self_test\.amplifier_v"):
            tested(amplifier_v=0.02)


class TestInASeries:
    def test_a_failed_self_test_refuses_the_series_and_leaves_no_file(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        engine = engine_with(ON, f"{WIRING}.outputs=[0, 2, 1]")
        job = acquire(engine, tmp_path / "jewel.h5")
        assert job.state is JobState.FAILED
        assert isinstance(job.error, SelfTestFailed)
        assert not (tmp_path / "jewel.h5").exists()
        assert engine.status().power_amplifier.enabled is False

    def test_comes_before_each_series_and_so_after_each_trip(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        engine = engine_with(ON, "backends.simulated.faults.amplifier_trip=[2]")
        world: Any = engine.platform.backends["simulated"].world  # type: ignore[attr-defined]
        tripped = acquire(engine, tmp_path / "first.h5")
        assert "tripped" in str(tripped.error)
        refused = acquire(engine, tmp_path / "refused.h5")
        assert "fault latched: over-current" in str(refused.error)
        assert "reset" in refused.error.remedy
        before = world.shots
        assert engine.reset_fault().fault == "over-current"
        assert world.shots == before
        shots = world.shots
        assert acquire(engine, tmp_path / "second.h5", shots=2).error is None
        assert world.shots == shots + 3

    def test_a_cancelled_series_is_cancelled_in_its_self_test_too(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        engine = engine_with(ON)
        assert acquire(engine, tmp_path / "jewel.h5").state is JobState.DONE

    def test_a_self_test_outside_the_limits_stops_the_start(self, engine_with: Callable[..., Engine]) -> None:
        with pytest.raises(SequenceRejected, match="current of coil"):
            engine_with(ON, "limits.max_coil_current_a=1e-3")

    def test_is_off_where_time_is_simulated_unless_asked_for(self, engine_with: Callable[..., Engine]) -> None:
        engine = engine_with()
        assert not SelfTest(engine.platform, engine.side, SelfTestOptions()).enabled


def test_a_silent_platform_without_any_noise_can_be_tested(tested: Callable[..., dict[str, Any]]) -> None:
    report = tested("backends.simulated.noise.scale=0.0")
    assert report.gain == pytest.approx({"x": 1.0, "y": 1.0, "z": 1.0}, abs=0.01)


def test_a_self_test_that_was_no_good_shot_itself_is_made_once_more(
    engine_with: Callable[..., Engine], tmp_path: Path
) -> None:
    faults = "backends.simulated.faults.corrupted"
    assert acquire(engine_with(ON, f"{faults}=[1]"), tmp_path / "once.h5").error is None
    job = acquire(engine_with(ON, f"{faults}=[1, 2]"), tmp_path / "twice.h5")
    assert isinstance(job.error, SelfTestFailed)
    assert not (tmp_path / "twice.h5").exists()


def queued(engine: Engine, folder: Path, request: SelfTestRequest, asked: SubmitOptions = SUBMIT_NOW) -> SelfTestJob:
    """The job of a self-test, planned as the platform service plans it."""
    folders = Folders(**dict.fromkeys(Folders.__dataclass_fields__, folder) | {"mounted": folder / "m.json"})
    return engine.submit(plan(HardwareBench(engine=engine, folders=folders), request), options=asked)


class TestAsked:
    def test_is_made_where_it_is_off_before_series_and_keeps_what_it_heard(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        engine = engine_with(jobs=tmp_path)
        job = queued(engine, tmp_path, SelfTestRequest(comment="new cables"), asked=SubmitOptions("self_test-mine"))
        assert job.ended.wait(60)
        assert (job.state, job.identifier) == (JobState.DONE, "self_test-mine")
        assert all(abs(gain - 1) < 0.3 for gain in job.result.gain.values())
        [kept] = JobRecords(tmp_path / "state.sqlite").load({"self_test"}, {"self_test"}, lambda job: None)
        assert (kept.result, kept.request.comment) == (job.result, "new cables")

    def test_a_chain_that_is_wrong_is_a_job_that_failed(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        engine = engine_with(f"{WIRING}.outputs=[0, 2, 1]")
        job = queued(engine, tmp_path, SelfTestRequest())
        assert job.ended.wait(60)
        assert job.state is JobState.FAILED
        assert "coil y is connected to output 2" in str(job.error)
        assert not engine.platform.amplifier.status().enabled

    def test_outside_the_limits_is_refused_before_it_waits(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        engine = engine_with("limits.max_coil_current_a=1e-3")
        with pytest.raises(SequenceRejected, match="current of coil"):
            queued(engine, tmp_path, SelfTestRequest())
        assert engine.job_ids("self_test") == ()
