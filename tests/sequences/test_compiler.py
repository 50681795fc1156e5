import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from drivers.errors import SequenceRejected
from drivers.timeline import DigitalLine
from platform_daemon.core.settings import load_sequence
from sequences.compiler import compile_shot
from sequences.request import SequenceRequest
from tests.kit.transmit_side import side

THREAD = load_sequence("thread")
JEWEL = load_sequence("jewel")


def changed(request: SequenceRequest, **keys: object) -> SequenceRequest:
    return SequenceRequest(**{**request.model_dump(), **keys})


def test_ten_periods_of_212_hz_become_2879_samples_and_212_0012_hz():
    plan = compile_shot(THREAD, side())
    assert plan.timeline.tx_samples == 2879
    assert plan.frequency_hz == pytest.approx(212.0012, abs=5e-5)
    assert plan.summary()["f_tx_requested_hz"] == 212.0


@pytest.mark.parametrize(("preset", "field_t", "rx_s"), [(THREAD, 215e-6, 15.0), (JEWEL, 490e-6, 2.0)])
def test_presets_are_the_papers_sequence_table(preset, field_t, rx_s):
    assert (preset.f_tx_hz, preset.tx_periods, preset.field_t, preset.rx_s) == (212.0, 10, field_t, rx_s)
    summary = compile_shot(preset, side()).summary()
    assert summary["t_tx_s"] == pytest.approx(0.047, abs=5e-4)
    assert summary["t_rx_s"] == pytest.approx(rx_s, abs=1e-5)


def test_the_drive_makes_a_zero_phase_field_without_transient_through_the_real_loop():
    request = changed(THREAD, axis=(0.6, -0.8, 0.0))
    plan = compile_shot(request, side())
    t = np.linspace(0, plan.timeline.tx_samples / plan.timeline.clock.rate_hz, 400)
    field = np.zeros((3, t.size))
    for burst, drive in zip(plan.timeline.bursts, plan.drives, strict=True):
        c = drive.channel

        def slope(time, i, b=burst, c=c):
            volts = c.amplifier_gain * b.amplitude_v * np.sin(2 * np.pi * b.frequency_hz * time + b.phase_rad)
            return (volts - c.resistance_ohm * i) / c.inductance_h

        current = solve_ivp(slope, (0, t[-1]), [0.0], t_eval=t, rtol=1e-10, atol=1e-13, max_step=1e-4).y[0]
        field += np.outer(c.field_per_ampere_t, current)
    wanted = request.field_t * np.outer([0.6, -0.8, 0.0], np.sin(2 * np.pi * plan.frequency_hz * t))
    np.testing.assert_allclose(field, wanted, atol=1e-6 * request.field_t)


def test_gate_and_receiver_are_apart_by_the_guard_and_low_at_rest():
    timeline = compile_shot(JEWEL, side()).timeline
    gate = [timeline.is_high(DigitalLine.PA_GATE, k) for k in range(timeline.rx_start + 10)]
    receive = [timeline.is_high(DigitalLine.RX_CONNECT, k) for k in range(timeline.rx_start + 10)]
    assert not any(g and r for g, r in zip(gate, receive, strict=True))
    assert receive.index(True) - max(k for k, g in enumerate(gate) if g) - 1 == JEWEL.guard_samples
    assert timeline.is_high(DigitalLine.RX_CONNECT, timeline.total_samples - 1)


def test_a_blank_shot_has_the_same_windows_but_neither_burst_nor_gate():
    plan, blank = compile_shot(JEWEL, side()), compile_shot(JEWEL, side(), blank=True)
    assert blank.timeline.total_samples == plan.timeline.total_samples
    assert blank.blank
    assert not blank.timeline.bursts
    assert all(level.line is DigitalLine.RX_CONNECT for level in blank.timeline.lines)


@pytest.mark.parametrize(
    ("keys", "limits", "where"),
    [
        ({"field_t": 2e-3}, {}, "field_t"),
        ({"field_t": 9e-4}, {"max_coil_current_a": 0.5}, "field_t"),
        ({"tx_periods": 100}, {}, "tx_periods"),
        ({"rx_s": 0.1}, {}, "tx_periods"),
        ({"rx_s": 1e-9}, {}, "rx_s"),
        ({"rx_s": 40.0}, {}, "rx_s"),
        ({"switch_s": 0.004}, {}, "switch_s"),
        ({"guard_samples": 600}, {}, "switch_s"),
        ({"f_tx_hz": 19e3}, {}, "f_tx_hz"),
        ({"f_tx_hz": 7000.0, "field_t": 9e-4, "tx_periods": 300}, {}, "field_t"),
    ],
)
def test_what_leaves_the_envelope_is_rejected_naming_key_and_remedy(keys, limits, where):
    with pytest.raises(SequenceRejected) as caught:
        compile_shot(changed(JEWEL, **keys), side(**limits))
    assert where in caught.value.where
    assert caught.value.remedy


def test_a_direction_the_coils_cannot_make_is_rejected():
    planar = side()
    planar = type(planar)(planar.channels[:2], planar.card, planar.switch, planar.limits)
    with pytest.raises(SequenceRejected, match="direction"):
        compile_shot(changed(JEWEL, axis="z"), planar)


@settings(max_examples=150, deadline=None)
@given(
    f=st.floats(50, 2000),
    periods=st.integers(1, 60),
    field=st.floats(1e-6, 2e-3),
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 1e-3),
    switch=st.floats(1e-3, 0.05),
    guard=st.integers(1, 3000),
    rx=st.floats(1e-3, 20.0),
)
def test_every_accepted_request_keeps_the_envelope_sample_by_sample(f, periods, field, axis, switch, guard, rx):
    platform = side()
    request = SequenceRequest(
        f_tx_hz=f, tx_periods=periods, field_t=field, axis=axis, switch_s=switch, guard_samples=guard, rx_s=rx
    )
    try:
        plan = compile_shot(request, platform)
    except SequenceRejected:
        return
    timeline, limits = plan.timeline, platform.limits
    levels = {line: np.zeros(timeline.total_samples, bool) for line in DigitalLine}
    for level in timeline.lines:
        levels[level.line][level.start_sample : level.stop_sample] = True
    assert not np.any(levels[DigitalLine.PA_GATE] & levels[DigitalLine.RX_CONNECT])
    assert plan.frequency_hz * timeline.tx_samples / timeline.clock.rate_hz == pytest.approx(periods)
    for drive in plan.drives:
        volts = timeline.output_volts(drive.channel.output, 0, timeline.total_samples)
        assert np.max(np.abs(volts)) * drive.channel.amplifier_gain <= drive.channel.amplifier_limit_v
        assert not np.any(volts[~levels[DigitalLine.PA_GATE]])
        assert abs(drive.current_a) <= limits.max_coil_current_a
    settled = np.argmax(levels[DigitalLine.RX_CONNECT]) + platform.switch.total_s * timeline.clock.rate_hz
    assert settled <= timeline.rx_start
