import numpy as np
import pytest

from drivers.errors import ConfigError
from sim_backend.backend import SimulatedBackend
from sim_backend.study import play
from tests.kit.simulated_bench import SWITCH, TX, Bench, options, specimen


def test_a_studys_first_shot_is_that_of_the_devices():
    drag = [{"id": "quadratic_drag", "strength": 1e-3}]
    bench = Bench("jewel", undeclared=drag)
    program = bench.line_up(rx=3000)
    backend = SimulatedBackend(options(undeclared=drag))
    first, second = play(backend, specimen("jewel"), program, shots=2, lna_gain=40.0)
    assert np.array_equal(first.volts, bench.shot(rx=3000)[:, TX + SWITCH :])
    assert first.truth["undeclared"] == bench.truth()["undeclared"]
    assert second.truth["shot"] == 2
    assert second.truth["f_nat_hz"] != first.truth["f_nat_hz"]


def test_every_shot_of_a_study_starts_from_rest():
    still = {f"effects__{name}__enabled": False for name in ("temperature", "friction_scatter", "wear")}
    backend = SimulatedBackend(options(**still))
    program = Bench("thread").line_up(rx=600)
    shots = list(play(backend, specimen("thread"), program, shots=3, lna_gain=40.0, between_s=0.1))
    angles = np.array([shot.truth["phi_max_rad"] for shot in shots])
    assert angles == pytest.approx(angles[0], rel=1e-12)


def test_a_gain_the_lna_does_not_have_is_refused():
    backend = SimulatedBackend(options())
    with pytest.raises(ConfigError, match="no gain 41"):
        next(play(backend, specimen("thread"), Bench("thread").line_up(rx=600), shots=1, lna_gain=41.0))
