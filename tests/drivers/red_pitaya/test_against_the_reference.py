"""The driver against a second server, written from the protocol's text: a misreading that driver and emulator share
would show here."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from drivers.conformance.io_card import collect
from drivers.conformance.timelines import short_shot
from drivers.errors import DeviceProtocolError, SequenceRejected
from drivers.io_card import CardState
from drivers.red_pitaya.card import RedPitayaCard
from drivers.red_pitaya.options import card_table
from drivers.timeline import DigitalLine
from tests.kit.reference_daq_server import ReferenceServer, code


@pytest.fixture
def opened():
    """A server with some memory, and a card on it; at the end nothing may have gone against the protocol."""
    made = []

    def make(server=None, **table):
        server = server or ReferenceServer()
        made.append(server)
        command_port, data_port = server.ports
        board = {"host": "127.0.0.1", "command_port": command_port, "data_port": data_port}
        card = RedPitayaCard(card_table({"boards": [board], **table}))
        made.append(card)
        return server, card

    yield make
    for each in reversed(made):
        each.close()
        assert getattr(each, "mistakes", []) == []


def volts_of(card, timeline):
    return np.concatenate([c.volts for c in collect(card, timeline, 5000)], axis=1)


@pytest.mark.parametrize("decimation", [1000, 2048])
def test_volts_are_the_counts_of_the_right_samples_by_calibration_and_filter_gain(opened, decimation):
    memory = {"ADC:0:SCALE": 3.05e-5, "ADC:1:SCALE": 6.1e-4, "ADC:0:OFFSET": 0.01, "ADC:1:OFFSET": -0.2}
    _, card = opened(ReferenceServer(memory), decimation=decimation, step_samples=32)
    timeline = short_shot(card.capabilities())
    delay = (decimation / 2 - 1) / 2 * 6 / decimation + (92 - 1) / 2 / 2
    gain = (decimation / 2) ** 6 / 2 ** np.ceil(6 * np.log2(decimation / 2))
    index = np.arange(timeline.total_samples) + round(delay)
    wanted = [code(index, 0) * 3.05e-5 / gain + 0.01, code(index, 1) * 6.1e-4 / gain - 0.2]
    assert np.allclose(volts_of(card, timeline), wanted, rtol=1e-6, atol=1e-7)
    lowest, highest = card.capabilities().input_range_v(1)  # of the converter, before any filter
    assert lowest == pytest.approx(-32768 * 6.1e-4 - 0.2)
    assert highest == pytest.approx(32767 * 6.1e-4 - 0.2)


def test_what_is_played_is_the_timeline_and_the_next_shot_is_armed_anew(opened):
    server, card = opened()
    timeline = short_shot(card.capabilities())
    for _ in range(3):
        volts_of(card, timeline)
    volts_of(card, short_shot(card.capabilities(), bursts=False))
    assert len(server.played) == 4
    for shot in server.played[:3]:
        step, values, enable = shot["step"], shot["values"], shot["enable"]
        samples = np.arange(len(values) * step)
        on = [timeline.is_high(DigitalLine.PA_GATE, k) for k in samples]
        receive = [timeline.is_high(DigitalLine.RX_CONNECT, k) for k in samples]
        assert np.array_equal(np.repeat(values[:, 2], step) > 0.9, on)
        assert np.array_equal(np.repeat(values[:, 3], step) > 0.9, receive)
        assert np.array_equal(np.repeat(enable[:, 0], step), on)  # the burst is as long as the gate
        assert set(shot["sines"]) == {("0", "0"), ("1", "0")}
    assert server.played[3]["sines"] == {}
    assert not server.played[3]["enable"][:, :2].any()
    assert sum("SEQ:LUT " in line for line in server.log) == 2  # only what is new
    assert sum("SEQ:SET" in line for line in server.log) == 4


def test_the_outputs_calibration_is_the_servers_and_the_driver_asks_in_volts(opened):
    server, card = opened(ReferenceServer({"DAC:0:SCALE": 0.8, "DAC:1:SCALE": 1.05}))
    timeline = short_shot(card.capabilities())
    volts_of(card, timeline)
    for (output, _), level in server.played[0]["sines"].items():
        volts = next(b.amplitude_v for b in timeline.bursts if b.output == int(output))
        assert level == pytest.approx(volts * server.calibration[f"DAC:{output}:SCALE"], abs=0.6 / 65534)


def test_full_scale_is_what_the_server_accepts_on_every_output(opened):
    _, card = opened(ReferenceServer({"DAC:1:SCALE": 1.05}))
    can = card.capabilities()
    assert can.output_full_scale_v == pytest.approx(1 / 1.05)
    timeline = short_shot(can)
    louder = can.output_full_scale_v / timeline.bursts[0].amplitude_v
    volts_of(card, scaled(timeline, louder))
    with pytest.raises(SequenceRejected, match="V of"):
        card.program(scaled(timeline, 1.001 * louder))


@pytest.mark.parametrize("scale", [0.9, 0.93, 1.0, 1.0001234, 1.000533, 1.05, 1.1])
def test_full_scale_can_be_armed_whatever_digits_the_scale_has(opened, scale):
    """The server tells six of them, and reads back by all."""
    server, card = opened(ReferenceServer({"DAC:0:SCALE": scale, "DAC:1:SCALE": scale}))
    can = card.capabilities()
    timeline = short_shot(can)
    card.program(scaled(timeline, can.output_full_scale_v / timeline.bursts[0].amplitude_v))
    card.arm()
    levels = server.amplitude.values()
    assert min(levels) >= max(levels) - 1 / 65534
    card.stop()


def test_an_output_that_a_finished_shot_left_on_is_switched_off(opened):
    server, card = opened()
    volts_of(card, short_shot(card.capabilities()))
    server.log.clear()
    card.stop()
    assert not [line for line in server.log if line.endswith("AMPLITUDE 0")]
    server.amplitude["1", "2"] = 1 / 32767
    card.stop()
    assert server.amplitude == {}


def scaled(timeline, factor):
    return replace(timeline, bursts=tuple(replace(b, amplitude_v=factor * b.amplitude_v) for b in timeline.bursts))


NONSENSE = [
    {"DAC:0:SCALE": 0.0},
    {"DAC:1:SCALE": 3.0},
    {"DAC:1:SCALE": 1e-30},
    {"DAC:0:OFFSET": 0.5},
    {"DAC:1:OFFSET": np.nan},
    {"DAC:0:LIMIT:LOWER": 0.5},
    {"DAC:0:LIMIT:UPPER": 0.0},
    {"DAC:1:LIMIT:UPPER": np.nan},
    {"DAC:0:OFFSET": -0.08, "DAC:1:OFFSET": 0.08, "DAC:1:LIMIT:UPPER": 0.15},  # nothing is left
    {"ADC:1:SCALE": np.nan},
    {"ADC:1:SCALE": 1e-9},
    {"ADC:0:OFFSET": np.inf},
    {"ADC:0:OFFSET": 0.9},
]


@pytest.mark.parametrize("memory", NONSENSE)
def test_a_memory_that_makes_no_sense_is_refused_by_name(memory):
    server = ReferenceServer(memory)
    command_port, data_port = server.ports
    board = {"host": "127.0.0.1", "command_port": command_port, "data_port": data_port}
    with pytest.raises(DeviceProtocolError, match=r"makes no sense.*" + next(iter(memory))[:3]):
        RedPitayaCard(card_table({"boards": [board]}))
    server.close()


def test_no_output_is_asked_for_more_than_its_limits_in_the_cards_memory_let_through(opened):
    _, card = opened(ReferenceServer({"DAC:0:LIMIT:LOWER": -0.25, "DAC:1:LIMIT:UPPER": 0.5}))
    assert card.capabilities().output_full_scale_v == 0.25
    timeline = short_shot(card.capabilities())
    volts_of(card, timeline)
    peak_v = max(burst.amplitude_v for burst in timeline.bursts)
    with pytest.raises(SequenceRejected):
        card.program(scaled(timeline, 0.26 / peak_v))


@pytest.mark.parametrize(
    ("memory", "full_scale_v"),
    [
        ({"DAC:0:OFFSET": 0.03}, 0.97),
        ({"DAC:1:OFFSET": -0.05, "DAC:1:SCALE": 1.1}, 1 / 1.1 - 0.05),
        ({"DAC:0:OFFSET": 0.05, "DAC:0:LIMIT:UPPER": 0.5}, 0.5),  # the server moves the limits by that offset, too
        ({"DAC:0:OFFSET": 0.05, "DAC:1:LIMIT:LOWER": -0.5}, 0.45),  # also those of the other output
        ({"DAC:0:OFFSET": 0.05, "DAC:1:OFFSET": -0.05, "DAC:1:LIMIT:LOWER": -0.5}, 0.4),
    ],
)
def test_what_an_offset_takes_of_the_converter_is_no_amplitudes(opened, memory, full_scale_v):
    _, card = opened(ReferenceServer(memory))
    can = card.capabilities()
    assert can.output_full_scale_v == pytest.approx(full_scale_v)
    with pytest.raises(SequenceRejected):
        card.program(scaled(short_shot(can), 1.001e3))


def test_an_image_of_another_version_is_refused_unless_the_platform_file_names_it(opened):
    server = ReferenceServer()
    server.image = 10
    with pytest.raises(DeviceProtocolError, match=r"image is version 10.*not 11"):
        opened(server)
    _, card = opened(server, image_version=10)
    assert card.identity().model


def test_whatever_survives_a_reconnect_is_set_and_the_outputs_are_off_before_anything_else(opened):
    server, card = opened(lines={"pa_gate": {"pin": "DIO7_P"}, "rx_connect": {"pin": "DIO6_P"}})
    pin = [line for line in server.log if "PIN7" in line]
    assert pin[0] == "RP:DIO:PIN7:SIDEP OFF"
    assert {"RP:DIO:PIN7:SIDEP:HBRIDGE OFF", "RP:DIO:PIN7:SIDEP:DIR OUT"} < set(pin)
    off = [server.log.index(f"RP:DAC:CHANNEL{o}:COMPONENT{c}:AMPLITUDE 0") for o in (0, 1) for c in range(3)]
    assert max(off) < server.log.index("RP:MODE ACQUISITION")
    kept = ("RP:ADC:FIRENABLED ON", "RP:ADC:DECIMATION 2048", "RP:TRIGGER:MODE INTERNAL", "RP:TRIGGER:ALIVE OFF")
    kept += ("RP:COUNTERTRIGGER:ENABLE OFF", "RP:DAC:CHANNEL0:RAMPING:ENABLE OFF", "RP:COUNTER:SAMPLESPERSTEP 0")
    assert set(kept) < set(server.log)
    assert card.state() is CardState.IDLE


def test_a_stop_in_every_state_leaves_the_server_quiet_and_the_next_shot_whole(opened):
    server, card = opened()
    timeline = short_shot(card.capabilities())
    steps = [lambda: card.program(timeline), card.arm, card.trigger, lambda: card.read(1000)]
    for count in range(len(steps) + 1):
        for step in steps[:count]:
            step()
        card.stop()
        assert card.state() is CardState.IDLE
        assert (server.mode, server.triggered_at, server.amplitude) == ("CONFIGURATION", None, {})
        server.mistakes = [m for m in server.mistakes if "went off before" not in m]  # a stop may
        assert volts_of(card, timeline).shape[1] == timeline.total_samples
