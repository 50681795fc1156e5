"""What the tests of this room share: the shipped configuration with changes, specimens, and a hand-made shot."""

from __future__ import annotations

import copy
import tomllib
from typing import Any

import numpy as np

from drivers.specimen import Specimen
from drivers.timeline import Burst, DigitalLine, LineLevel, SampleClock, Timeline
from sim_backend.backend import SimulatedBackend
from tests.kit.data import CONFIG

CLOCK = SampleClock(125e6, 2048)
TX = 2879
SWITCH = 671  # 11 ms
FIELD_T = {"thread": 215e-6, "jewel": 490e-6}


def table() -> dict[str, Any]:
    return tomllib.loads((CONFIG / "platforms" / "simulated.toml").read_text())


def options(**changes: Any) -> dict[str, Any]:
    """[backends.simulated] as shipped; changes are dotted paths with __ between keys, and their values."""
    out = copy.deepcopy(table()["backends"]["simulated"])
    for path, value in changes.items():
        *way, last = path.split("__")
        inner = out
        for key in way:
            inner = inner[key]
        inner[last] = value
    return out


QUIET: dict[str, Any] = {
    "noise__scale": 0.0,
    "effects__temperature__enabled": False,
    "effects__friction_scatter__enabled": False,
    "effects__wear__enabled": False,
    "switch__transient_v": [0.0, 0.0, 0.0],
    "card__adc_bits": 24,
}


def specimen(name: str) -> Specimen:
    return Specimen.model_validate(tomllib.loads((CONFIG / "resonators" / f"{name}.toml").read_text()))


def timeline(
    channel: Any, field_t: float, rx: int = 12207, tx: int = TX, switch: int = SWITCH, periods: int = 10, **extra: Any
) -> Timeline:
    """Zero-phase sine field along one axis, then switch, then receive."""
    f = periods * CLOCK.rate_hz / tx
    z = channel.impedance_ohm(f)
    amps = field_t / np.linalg.norm(channel.field_per_ampere_t)
    burst = Burst(channel.output, 0, tx, f, amps * abs(z) / channel.amplifier_gain, float(np.angle(z)))
    lines = (LineLevel(DigitalLine.PA_GATE, 0, tx), LineLevel(DigitalLine.RX_CONNECT, tx + 30, tx + switch + rx))
    return Timeline(CLOCK, tx, switch, rx, (burst,) if field_t else (), extra.get("lines", lines))


class Bench:
    """A back end with all devices open and a specimen mounted."""

    def __init__(self, name: str | None = "thread", **changes: Any) -> None:
        shipped = table()
        self.backend = SimulatedBackend(options(**changes))
        own = {k: {a: b for a, b in v.items() if a != "backend"} for k, v in shipped.items() if isinstance(v, dict)}
        self.calibration = self.backend.receive_calibration(own["calibration"])
        self.card = self.backend.io_card(own["io_card"])
        self.switch = self.backend.tx_rx_switch(own["tx_rx_switch"])
        self.amplifier = self.backend.power_amplifier(own["power_amplifier"])
        self.lna = self.backend.lna(own["lna"])
        self.thermometer = self.backend.thermometer(own["thermometer"])
        self.channels = self.backend.transmit_channels(own["coils"])
        self.clock = self.backend.clock()
        self.name = name
        if name is not None:
            self.backend.mount(specimen(name))

    def line_up(self, field_t: float | None = None, **more: Any) -> Timeline:
        field = FIELD_T[self.name or "thread"] if field_t is None else field_t
        return timeline(self.channels[more.pop("axis", 0)], field, **more)

    def start(self, program: Timeline) -> None:
        self.switch.to_transmit()
        self.amplifier.enable()
        self.amplifier.unmute()
        self.card.program(program)
        self.card.arm()
        self.card.trigger()

    def shot(self, field_t: float | None = None, chunk: int = 100_000, **more: Any) -> np.ndarray:
        """(3, n) float64 V of one whole frame; amplifier muted afterwards."""
        program = self.line_up(field_t, **more)
        self.start(program)
        parts, done = [], 0
        while done < program.total_samples:
            piece = self.card.read(chunk)
            assert piece.first_sample == done
            parts.append(piece.volts)
            done += piece.volts.shape[1]
        self.amplifier.mute()
        return np.concatenate(parts, axis=1).astype(np.float64)

    def truth(self) -> dict[str, Any]:
        found = self.backend.ground_truth()
        assert found is not None
        return dict(found)
