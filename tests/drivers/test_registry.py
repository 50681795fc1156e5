"""A third party's back end, found by entry point, without touching the project."""

from importlib.metadata import EntryPoint

import numpy as np
import pytest

from drivers import entry_points, registry
from drivers.calibration import ReceiveCalibration
from drivers.errors import ConfigError, DeviceError
from drivers.io_card import CardCapabilities
from drivers.registry import PlatformSection, build_platform, load_backend
from drivers.timeline import SampleClock
from drivers.validation import validated

DEVICES = ("io_card", "tx_rx_switch", "power_amplifier", "lna", "coils", "calibration")
TABLES = {"name": "theirs", **{d: {"backend": "theirs"} for d in DEVICES}}


class Part:
    def __init__(self, name: str, log: list[str], fails: bool = False) -> None:
        self.name, self.log, self.fails = name, log, fails

    def _note(self, what: str) -> None:
        self.log.append(f"{self.name}.{what}")
        if self.fails:
            raise DeviceError(f"{self.name} does not answer")

    def stop(self) -> None:
        self._note("stop")

    on_card_lines = False
    reads_back = True

    def disable(self) -> None:
        self._note("disable")

    def gain(self) -> float:
        return 40.0

    def capabilities(self) -> CardCapabilities:
        return CardCapabilities(
            inputs=1,
            outputs=1,
            input_full_scale_v=1.0,
            output_full_scale_v=1.0,
            clock=SampleClock(125e6, 2048),
            max_samples=1000,
        )

    def to_transmit(self) -> None:
        self._note("to_transmit")

    def close(self) -> None:
        self._note("close")


class TheirBackend:
    built = 0
    log: list[str]

    def __init__(self, options):
        type(self).built += 1
        type(self).log = []
        self.options = options

    def __getattr__(self, kind):
        if kind not in (*DEVICES, "thermometer", "transmit_channels"):
            raise AttributeError(kind)

        def make(options):
            if options.get("broken"):
                raise ConfigError("key 'broken' is unknown", where=kind)
            return Part(kind, self.log, fails=options.get("fails", False))

        return make

    def receive_calibration(self, options):
        return ReceiveCalibration(np.eye(3), "theirs", "2026-01-01", lna_gain=40.0)

    def clock(self):
        return registry.SystemClock()

    def warm_up(self):
        self.log.append("warm_up")

    def mount(self, specimen):
        self.log.append("mount")

    def ground_truth(self):
        return None


@pytest.fixture(autouse=True)
def theirs(monkeypatch):
    point = EntryPoint("theirs", f"{__name__}:TheirBackend", entry_points.BACKENDS)
    monkeypatch.setattr(entry_points, "entry_points", lambda group: [point])
    TheirBackend.built = 0


def section(**tables):
    return validated(PlatformSection, TABLES | tables, "theirs.toml")


def test_one_back_end_serves_all_its_devices():
    platform = build_platform(section(backends={"theirs": {"address": "a"}}))
    assert TheirBackend.built == 1
    assert platform.backends["theirs"].options == {"address": "a"}
    assert platform.ground_truth() == {}


def test_an_unknown_back_end_is_named_with_those_that_are_installed():
    with pytest.raises(ConfigError, match=r"'ours'.*installed are: theirs"):
        load_backend("ours", {})


def test_options_for_a_back_end_that_no_device_uses_are_an_error():
    with pytest.raises(ConfigError, match="nobody"):
        build_platform(section(backends={"nobody": {}}))


def test_a_device_that_cannot_be_built_leaves_none_open():
    with pytest.raises(ConfigError):
        build_platform(section(lna={"backend": "theirs", "broken": True}))
    assert TheirBackend.log == ["power_amplifier.close", "tx_rx_switch.close", "io_card.close"]


def test_outputs_off_tries_every_step_and_then_names_all_that_failed():
    platform = build_platform(section(io_card={"backend": "theirs", "fails": True}))
    with pytest.raises(DeviceError, match="io_card does not answer"):
        platform.outputs_off()
    assert sorted(TheirBackend.log) == ["io_card.stop", "power_amplifier.disable", "tx_rx_switch.to_transmit"]
    assert TheirBackend.log.index("io_card.stop") < TheirBackend.log.index("tx_rx_switch.to_transmit")


@pytest.mark.parametrize("missing", DEVICES[:-1])
def test_a_missing_device_table_is_named(missing):
    tables = {k: v for k, v in TABLES.items() if k != missing}
    with pytest.raises(ConfigError, match=missing):
        validated(PlatformSection, tables, "theirs.toml")


def test_a_device_table_without_back_end_is_named():
    with pytest.raises(ConfigError, match=r"lna\.backend"):
        section(lna={"gain": 40})


def test_a_back_end_whose_package_cannot_be_imported_is_named_with_the_reason(monkeypatch):
    point = EntryPoint("theirs", "a_package_that_is_not_there:Backend", entry_points.BACKENDS)
    monkeypatch.setattr(entry_points, "entry_points", lambda group: [point])
    with pytest.raises(ConfigError, match=r"'theirs' cannot be loaded.*No module named.*Remedy: install what it needs"):
        load_backend("theirs", {})
