import threading

import numpy as np
import pytest

from drivers.errors import ConfigError, DeviceFault
from drivers.registry import PlatformSection, build_platform, load_backend
from sim_backend.backend import SimulatedBackend
from sim_backend.receive.calibration import calibration_frequencies_hz
from tests.kit.simulated_bench import Bench, options, table


def test_shipped_platform_builds_through_the_registry():
    shipped = table()
    for of_the_daemon in ("limits", "uncertainty"):
        shipped.pop(of_the_daemon, None)
    platform = build_platform(PlatformSection(**shipped))
    assert [t.axis for t in platform.transmit] == ["x", "y", "z"]
    assert platform.calibration.lna_gain == platform.lna.gain() == 40.0
    assert platform.ground_truth() == {}
    assert isinstance(load_backend("simulated", options()), SimulatedBackend)


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"seed": "7"}, "seed"),
        ({"seed": -1}, "seed"),
        ({"noise__scale": float("nan")}, "noise.scale"),
        ({"noise__sd_am2_per_s": [1.0, 2.0]}, "sd_am2_per_s"),
        ({"switch__dead_time_s": -1.0}, "dead_time_s"),
        ({"switch__dead_time_ms": 3.0}, "dead_time_ms"),
        ({"receive__chain": "perfect"}, "receive"),
        ({"receive__chains__ideal__poles_hz": [[1e4, 1.001e4], [], []]}, "ideal"),
        ({"lna__gains": [10.0, 1.0]}, "lna"),
        ({"coils__x__turns": 56.5}, "turns"),
        ({"faults__gremlins": [1]}, "gremlins"),
        ({"faults__corrupted": [0]}, "corrupted"),
        ({"clock__mode": "warp"}, "mode"),
    ],
)
def test_a_wrong_key_is_named(change, key):
    with pytest.raises(ConfigError, match=key):
        SimulatedBackend(options(**change))


def test_a_missing_key_is_named():
    incomplete = options()
    del incomplete["coils"]["y"]
    with pytest.raises(ConfigError, match=r"coils\.y"):
        SimulatedBackend(incomplete)


@pytest.mark.parametrize(
    ("device", "own"),
    [
        ("lna", {"gain": 41.0}),
        ("lna", {}),
        ("io_card", {"base_frequency_hz": 125e6, "decimation": 2048}),
        ("tx_rx_switch", {"speed": 1}),
        ("calibration", {}),
    ],
)
def test_device_tables_are_checked_too(device, own):
    backend = SimulatedBackend(options())
    maker = backend.receive_calibration if device == "calibration" else getattr(backend, device)
    with pytest.raises(ConfigError, match=device):
        maker(own)


def test_calibration_errors_can_be_asked_for():
    own = {k: v for k, v in table()["calibration"].items() if k != "backend"}
    backend = SimulatedBackend(options())
    exact, wrong = (backend.receive_calibration(own | {"gain_error": e}) for e in ([0.0] * 3, [0.01, 0.0, -0.02]))
    assert np.diag(wrong.sensitivity) / np.diag(exact.sensitivity) == pytest.approx([1.01, 1.0, 0.98])


def test_calibration_frequencies_reach_the_highest_and_resolve_the_rotor_lines():
    f = calibration_frequencies_hz(30500.0)
    assert f[0] == 0.0
    assert f[-1] >= 30500.0
    assert np.all(np.diff(f) > 0)
    assert np.diff(f[f < 3000]).max() <= 10.0


def test_linear_interpolation_of_the_calibrated_response_is_good_to_2e_7_below_two_kilohertz():
    bench = Bench(None, receive__chain="non_ideal")
    from sim_backend.receive.response import frequency_response

    f = np.linspace(100, 2000, 5000)
    exact = frequency_response(bench.backend.options.receive.in_place(), f)
    for row, wanted in zip(bench.calibration.frequency_response, exact, strict=True):
        assert np.abs(np.interp(f, bench.calibration.frequency_hz, row) - wanted).max() < 2e-7


def test_world_has_no_result_before_the_first_shot():
    with pytest.raises(DeviceFault, match="no shot"):
        Bench("thread").backend.world.shot_simulator.result()


def test_status_polling_from_other_threads_does_not_deadlock_a_series():
    bench, over = Bench("jewel"), threading.Event()

    def poll():
        while not over.is_set():
            bench.amplifier.status()
            bench.lna.overloaded()
            bench.switch.position()
            bench.backend.ground_truth()
            bench.card.state()

    pollers = [threading.Thread(target=poll) for _ in range(3)]
    for each in pollers:
        each.start()
    try:
        for _ in range(4):
            bench.shot(rx=3000, chunk=1000)
    finally:
        over.set()
        for each in pollers:
            each.join(timeout=30)
    assert not any(each.is_alive() for each in pollers)
    assert bench.truth()["shot"] == 4
