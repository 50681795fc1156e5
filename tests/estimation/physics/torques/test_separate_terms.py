"""A term that is compiled by itself fits like one that the kernels inline, and leaves their cache alone."""

import pickle
from pathlib import Path

import numba
import numpy as np
import pytest

from platform_daemon.estimation.compilation import synthetic_record
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.numerics import jit
from platform_daemon.estimation.physics import torques
from platform_daemon.estimation.physics.models import MODELS, model_named
from platform_daemon.estimation.physics.ring_down import RingDown
from platform_daemon.estimation.physics.torques.dispatch import LARGEST_NUMBER, acceleration, timed_acceleration
from platform_daemon.estimation.physics.trajectory.direct_chain import trace_half_cycles
from platform_daemon.estimation.physics.trajectory.half_cycle_chain import walk_half_cycles
from platform_daemon.estimation.physics.trajectory.half_cycle_table import build_table
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.separate_terms import CUBIC_DRAG, SEPARATE_DRAG, SEPARATE_DRIFT

KERNELS = (trace_half_cycles, walk_half_cycles, build_table)
PAIRS = pytest.mark.parametrize(
    ("separate", "inlined"), [("separate_drag", "quadratic_drag"), ("separate_drift", "frequency_drift")]
)


@numba.njit
def compiled(phi, v, sigma, codes, widths, c, grad):
    return acceleration(phi, v, sigma, codes, widths, c, grad)


@numba.njit
def compiled_timed(phi, v, u, sigma, codes, widths, c, grad):
    return timed_acceleration(phi, v, u, sigma, codes, widths, c, grad)


@pytest.fixture(autouse=True)
def listed(monkeypatch):
    monkeypatch.setattr(torques, "SEPARATE", (SEPARATE_DRAG, SEPARATE_DRIFT, CUBIC_DRAG))
    for term in torques.SEPARATE:
        monkeypatch.setitem(torques.TERMS, term.name, term)


@PAIRS
def test_it_fits_as_the_same_term_does_inlined_and_no_kernel_is_compiled_for_it(separate, inlined):
    record, noise = synthetic_record()
    expected = fit_ring_down(record, model_named(f"thread+{inlined}"), noise=noise)
    before = [kernel.stats.cache_misses for kernel in KERNELS]
    found = fit_ring_down(record, model_named(f"thread+{separate}"), noise=noise)
    assert [kernel.stats.cache_misses for kernel in KERNELS] == before
    assert found.verdict == expected.verdict
    assert found.chi2_per_dof == pytest.approx(expected.chi2_per_dof, rel=1e-12)
    values = [[e.value for e in fit.parameters.values()] for fit in (found, expected)]
    assert values[0] == pytest.approx(values[1], rel=1e-7)


def test_a_coefficient_in_seconds_is_found_again():
    """Its drag is the only loss, so that its first guess has to come from the decay."""
    model, q, rate_hz = model_named("undamped+cubic_drag"), 1e-6, 61035.0
    known = {"f_nat_hz": 210.0, "m_r_am2": 0.012, "phi_max_rad": 0.9, "psi_start_rad": 1.0, "cubic_drag_s": q}
    ring_down = RingDown.from_parameters(model, known)
    phi, v = ring_down.motion(12000, 1 / rate_hz)
    dmdt = 0.012 * ring_down.dynamics.w * v * np.array([-np.sin(phi), np.cos(phi), np.zeros_like(phi)])
    dmdt += np.random.default_rng(0).normal(0.0, 0.02, dmdt.shape)
    fit = fit_ring_down(RingDownRecord(dmdt, rate_hz, "dmdt"), model, noise=NoiseModel.white(np.full(3, 0.02), rate_hz))
    assert fit.verdict == "good", fit.reason
    found = fit.parameters["cubic_drag_s"]
    assert abs(found.value - q) < 5.0 * found.std < 0.1 * q


@PAIRS
def test_plain_python_and_compiled_code_give_the_same(separate, inlined):
    """The dispatch in both forms: the address is called, or the function found by it."""
    model = model_named(f"thread+{separate}")
    c = np.array([q.typical for q in model.coefficients])
    for plain, fast, moment in ((acceleration, compiled, (1.0,)), (timed_acceleration, compiled_timed, (37.0, 1.0))):
        grads = np.zeros((2, c.size + 1))
        args = (0.3, 0.2, *moment, model.codes, model.widths, c)
        assert fast(*args, grads[1]) == pytest.approx(plain(*args, grads[0]), rel=1e-14)
        assert grads[1] == pytest.approx(grads[0], rel=1e-14)


def test_a_model_in_another_process_finds_the_addresses_there():
    model = model_named("thread+separate_drag")
    assert abs(int(model.codes[-1])) > LARGEST_NUMBER
    assert "codes" not in pickle.loads(pickle.dumps(model)).__dict__
    assert pickle.loads(pickle.dumps(model)) == model


def test_a_term_that_is_not_listed_is_refused_with_its_name(monkeypatch):
    monkeypatch.delitem(torques.TERMS, "separate_drag")
    with pytest.raises(ValueError, match="separate_drag"):
        MODELS["thread"].with_terms("own", SEPARATE_DRAG)


def test_an_edited_separate_term_is_compiled_again_and_no_kernel_is(tmp_path):
    source = Path(SEPARATE_DRAG.function.__code__.co_filename).read_text()

    def digest_of(text):
        (tmp_path / "own.py").write_text(text)
        names = {}
        exec(compile(text, tmp_path / "own.py", "exec"), names)
        return jit.separate_digest(names["separate_drag"])

    assert digest_of(source) == digest_of(source)
    assert digest_of(source) != digest_of(source.replace("-2.0", "-3.0"))
    assert not jit.has_kernels(source.encode())
