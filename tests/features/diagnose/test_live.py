"""The loop on a simulated platform with effects that nobody declared."""

import json
import signal
import subprocess
from dataclasses import replace

import pytest

from drivers.errors import InputError
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.features.acquire.series_plan import plan_series
from platform_daemon.features.diagnose.live import Budget, Callbacks, LiveDiagnosis, variations
from tests.kit.command_line import COMMAND, assert_one_line_error, here, wait_for


def loop(engine, folder, budget=6, seconds=600.0, callbacks=None, kind=LiveDiagnosis, **keys):
    request = AcquisitionRequest(
        **{"resonator": "thread", "shots": 2, "sequence": {"rx_s": 0.5}, "window": None, **keys}
    )
    return kind(engine, request, folder, Budget(budget, seconds), callbacks or Callbacks())


def hidden(text):
    return f"backends.simulated.undeclared=[{{{text}}}]"


@pytest.mark.long
def test_a_platform_without_a_hidden_effect_is_left_alone_after_the_first_series(engine_with, tmp_path):
    live = loop(engine_with(), tmp_path)
    live.run()
    assert live.stopped == "nothing is missing"
    assert [r.measurement for r in live.rounds] == ["first_series"]
    assert live.log().recordings[0].sha256 is not None


@pytest.mark.campaign
def test_look_alikes_are_told_apart_by_what_the_platform_measures_next(engine_with, tmp_path):
    live = loop(engine_with(hidden('id="coulomb_friction", strength=60.0')), tmp_path, budget=16)
    live.run()
    first, *further = live.rounds
    assert first.effects[0].indistinguishable_from, "the first series must not tell them apart"
    assert {r.measurement for r in further} <= {"second_amplitude", "longer_window", "more_shots"}
    assert all(r.expected_sigma > 0 and r.why.startswith("separates") for r in further)
    assert live.stopped == "explained, and told apart from look-alikes"
    (found,) = live.rounds[-1].effects
    assert found.id == "coulomb_friction"
    assert abs(found.strength.value - 60.0) < 5 * found.strength.std
    assert sorted(tmp_path.glob("*.h5")) == sorted(tmp_path / r.file for r in live.rounds)


class TurnedFirst(LiveDiagnosis):
    """With this manual step before all others, of which chance decides where it ranks."""

    def _next(self):
        ranked = sorted(self.found.next_measurements, key=lambda p: p.measurement.key != "turn_90_deg")
        self.found = replace(self.found, next_measurements=tuple(ranked))
        return super()._next()


@pytest.mark.campaign
def test_the_budget_ends_the_loop_and_manual_steps_are_asked_once_or_listed(engine_with, tmp_path):
    engine, asked = engine_with(hidden('id="channel_delay", strength=2e-6, axis="y"')), []
    live = loop(engine, tmp_path, budget=4, sequence={"rx_s": 1.0})
    live.run()
    assert live.stopped == "out of budget: shots"
    assert live.log().shots == 4
    assert "turn_90_deg" in live.left
    assert "calibrate_2f" in live.left

    def done(step):
        asked.append(step.key)
        return True

    live = loop(
        engine, tmp_path, budget=4, sequence={"rx_s": 1.0}, callbacks=Callbacks(confirmed=done), kind=TurnedFirst
    )
    live.run()
    assert asked == ["turn_90_deg"]
    assert [r.measurement for r in live.rounds] == ["first_series", "turn_90_deg"]
    assert len(list(tmp_path.glob("*.h5"))) == 4


def test_variations_keep_the_request_and_change_what_the_measurement_says(engine_with, tmp_path):
    live = loop(engine_with(), tmp_path)
    plan = plan_series(live.engine, live.first)
    for key, name in (("second_amplitude", "field_t"), ("longer_window", "rx_s"), ("other_excitation_axis", "axis")):
        made = variations(live.first, plan, key)
        assert made
        for request in made:
            changed = plan_series(live.engine, request).sequence
            same = changed.model_dump() | {name: getattr(plan.sequence, name)}
            assert same == plan.sequence.model_dump()
            assert getattr(changed, name) != getattr(plan.sequence, name)
    assert [r.shots for r in variations(live.first, plan, "more_shots")] == [8, 16]
    assert all(r.blank_shots > 0 for r in variations(live.first, plan, "blank_shots"))
    assert variations(live.first, plan, "turn_90_deg") == []


def test_what_cannot_be_measured_is_refused_before_anything_moves(engine_with, tmp_path):
    live = loop(engine_with(), tmp_path, sequence={"field_t": 0.9})
    with pytest.raises(InputError):
        live.run()
    assert not list(tmp_path.iterdir())


@pytest.mark.long
def test_ctrl_c_leaves_outputs_off_and_keeps_what_was_measured(tmp_path):
    command = [
        COMMAND,
        "diagnose",
        "--live",
        "--resonator",
        "thread",
        "--out",
        tmp_path,
        "--shots",
        "500",
        "--rx-s",
        "0.5",
    ]
    command += ["--budget-shots", "500"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_for(lambda: sum(p.is_file() for p in tmp_path.rglob("*")) > 4 or process.poll() is not None)
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "outputs are off" in errors
    assert "Traceback" not in errors
    log = json.loads((tmp_path / "live-01.json").read_text())
    assert log["stopped"] == "interrupted"
    assert 0 < log["shots"] == log["rounds"][0]["shots"] < 500
    assert (tmp_path / "round01-first_series.h5").is_file()


def test_options_that_make_no_sense_end_with_one_line(tmp_path):
    assert_one_line_error(here("diagnose", "--live", "--out", tmp_path), 2, "--resonator")
    assert_one_line_error(here("diagnose", "--live", "--resonator", "spring", "--out", tmp_path), 2, "spring")
