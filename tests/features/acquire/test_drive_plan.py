"""A planned drive on the simulated platform: further than sine and chirp of the same peak, also when a bit wrong."""

import math

import pytest

from drivers.errors import SequenceRejected
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.settings import load_platform
from platform_daemon.features.acquire.destination import OwnFile
from platform_daemon.features.acquire.series_plan import plan_series, series_work
from platform_daemon.processes.assembly import start_engine
from tests.kit.acquisitions import acquire

QUIET = ("backends.simulated.effects.temperature.enabled=false", "limits.max_tx_s=1.0", "limits.max_tx_duty=0.6")
COMMON = {"rx_s": 0.4, "field_t": 60e-6, "f_tx_hz": 215.69}
MODEL = {"phase_plan": "model"}


def reached_deg(truth):
    return math.degrees(next(iter(truth.values()))["amplitude_tx_end_rad"])


@pytest.fixture(scope="module")
def reached(tmp_path_factory):
    """Amplitude at the end of TX, degrees, of one shot from rest with these keys."""
    folder = tmp_path_factory.mktemp("drives")
    engines = []

    def measured(variant="thread", **keys):
        engines.append(start_engine(load_platform("simulated", QUIET)))
        file = folder / f"{len(engines)}.h5"
        job = acquire(engines[-1], file, resonator=variant, sequence=COMMON | keys, window=None)
        engines[-1].close()
        assert job.error is None
        return reached_deg(read_truth(file)[0])

    return measured


def planned_deg(**keys):
    engine = start_engine(load_platform("simulated", QUIET))
    try:
        asked = {"resonator": "thread", "sequence": COMMON | MODEL | keys}
        return math.degrees(
            plan_series(engine, AcquisitionRequest.model_validate(asked)).summary().shot.planned_phi_max_rad
        )
    finally:
        engine.close()


@pytest.mark.long
@pytest.mark.parametrize(("periods", "least"), [(60, 1.3), (120, 1.5)])
def test_a_planned_field_swings_the_rotor_further_than_a_sine_or_a_chirp_of_its_peak(reached, periods, least):
    planned = reached(tx_periods=periods, **MODEL)
    assert planned > least * reached(tx_periods=periods)
    assert planned > 1.05 * reached(tx_periods=periods, chirp_hz=-5.0)
    assert planned == pytest.approx(planned_deg(tx_periods=periods), rel=0.03)
    assert reached(tx_periods=periods, waveform="rectangle", **MODEL) > 1.1 * planned


@pytest.mark.parametrize("wrong", [{"f_nat_hz": 215.69 * 0.997}, {"m_r_am2": 11.014e-3 * 0.95}])
def test_a_model_that_is_a_bit_wrong_still_beats_the_sine(reached, wrong):
    planned = reached(tx_periods=60, plan_parameters=wrong, **MODEL)
    believed = wrong.get("f_nat_hz", 215.69)
    assert planned > 1.1 * reached(tx_periods=60, f_tx_hz=believed)


def test_a_field_across_both_axes_of_the_rotor_is_planned_too(reached):
    # v is along x, u along -y: the part along u pushes only a rotor that is turned already.
    planned = reached(tx_periods=60, axis=(0.8, 0.6, 0.0), **MODEL)
    assert planned == pytest.approx(planned_deg(tx_periods=60, axis=(0.8, 0.6, 0.0)), rel=0.03)
    assert planned > 1.15 * reached(tx_periods=60, axis=(0.8, 0.6, 0.0))


@pytest.mark.parametrize(
    ("keys", "word"),
    [
        ({"axis": "z"}, "hardly along v"),
        ({"axis": "y"}, "hardly along v"),
        ({"field_t": 4e-4, "tx_periods": 120}, "90 degrees"),
        ({"plan_parameters": {"f_nat": 212.0}}, "has no f_nat"),
        ({"plan_parameters": {"f_nat_hz": -1.0}}, "cannot be -1"),
    ],
)
def test_what_cannot_be_planned_is_refused_before_anything_moves(keys, word):
    with pytest.raises(SequenceRejected) as caught:
        planned_deg(**{"tx_periods": 60, **keys})
    assert word in str(caught.value)


def test_a_rotor_held_by_friction_is_told():
    engine = start_engine(load_platform("simulated", QUIET))
    asked = {"resonator": "jewel", "sequence": COMMON | MODEL | {"field_t": 1e-6, "tx_periods": 10}}
    with pytest.raises(SequenceRejected, match="no drive can be planned"):
        plan_series(engine, AcquisitionRequest.model_validate(asked))
    engine.close()


def test_the_next_drive_follows_the_fit_of_the_last_shot(tmp_path):
    """The first one is planned with a natural frequency that is 0.3 % wrong, the second with the fitted one."""
    engine = start_engine(load_platform("simulated", QUIET))
    sequence = COMMON | {"tx_periods": 60, "pause_s": 25.0, "phase_plan": "last_fit"}
    sequence["plan_parameters"] = {"f_nat_hz": 215.69 * 0.997}
    job = acquire(engine, tmp_path / "a.h5", resonator="thread", shots=2, sequence=sequence, window="n50")
    engine.close()
    assert job.error is None
    first, second = (reached_deg(truth) for truth in read_truth(tmp_path / "a.h5"))
    assert second > 1.02 * first
    assert second == pytest.approx(planned_deg(tx_periods=60), rel=0.03)
    told = [frame.excitation for frame in open_recording(tmp_path / "a.h5").frame_info]
    assert all(made.waveform == "sine, phase planned" for made in told)
    assert told[0].realised_hz < told[1].realised_hz - 0.3


def test_shots_change_in_turn_and_are_kept_with_what_was_changed(tmp_path):
    engine = start_engine(load_platform("simulated", QUIET))
    changes = [{"field_t": 30e-6, "tx_periods": 8}, {"field_t": 60e-6}]
    asked = {"resonator": "thread", "blank_shots": 1, "shots": 3, "sequence": {"rx_s": 0.3}, "window": None}
    plan = plan_series(engine, AcquisitionRequest.model_validate(asked | {"shot_changes": changes}))
    assert [s.field_t for s in plan.summary().shots_in_turn] == [30e-6, 60e-6]
    job = engine.submit(series_work(engine, plan, OwnFile(tmp_path / "a.h5", tmp_path)))
    assert job.ended.wait(60)
    engine.close()
    assert job.error is None
    frames = open_recording(tmp_path / "a.h5").frame_info
    assert [f.excitation.field_t for f in frames] == pytest.approx([0.0, 30e-6, 60e-6, 30e-6])
    assert [f.excitation.periods for f in frames][1:] == [8, 10, 8]
    assert frames[0].step is None
    assert frames[2].step.label.values == {"field_t": 60e-6}
    assert plan.summary().disk_bytes == sum(s.timeline.total_samples for s in plan.shots) * 12
    lengths_s = [s.timeline.duration_s for s in plan.shots]
    assert plan.duration_s == pytest.approx(sum(lengths_s) + plan.sequence.pause_s * (len(lengths_s) - 1))
    assert plan.summary().shots == len(lengths_s)
