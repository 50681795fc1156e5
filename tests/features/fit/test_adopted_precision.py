"""What is predicted for adopted models of one angle is what fits with them state, and how their results scatter."""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from drivers.calibration import ReceiverEffect
from drivers.errors import InputError
from platform_daemon.core.schemas.requests import SequencePatch
from platform_daemon.core.settings import load_specimen
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.features.fit.precision import planned_model, planned_precision
from platform_daemon.features.models.adopted_model import AdoptedModel
from platform_daemon.features.models.library import Library
from platform_daemon.features.models.schema import AdoptedTermRecord
from tests.kit.ring_down_generator import NOISE_SD, RATE_HZ
from tests.kit.scipy_swings import thread_dm_dt

THREAD, _ = load_specimen("thread")
JEWEL, _ = load_specimen("jewel")
MAIN = {"f_nat_hz": 215.3, "m_r_am2": 0.0115, "lambda_per_s": 0.28}
PHI_RAD, WINDOW_S, FITS = 0.35, 0.24, 24
STRENGTHS = {
    "coulomb_friction": ("coulomb_rad_per_s2", "dry"),
    "quadratic_drag": ("quadratic_drag_per_rad", "drag"),
}


def adopted(term, strength, *, free=False, base="thread", receiver=()):
    """A model as a diagnosis with the values MAIN makes it."""
    name = STRENGTHS[term][0]
    diagnosis = {"parameters_after": {n: {"value": v, "std": 0.0} for n, v in MAIN.items()}}
    record = AdoptedTermRecord(term=term, values={name: strength}, std={name: None}, free=free)
    return AdoptedModel("dusty", 1, base, (record,), receiver, {"diagnosis": diagnosis})


def predicted(model, specimen=THREAD, **more):
    return planned_precision(specimen, [WINDOW_S], phi_max_rad=PHI_RAD, model=model, **more)


@pytest.mark.parametrize(
    ("term", "strength", "free"),
    [
        ("coulomb_friction", 30.0, False),
        ("coulomb_friction", 30.0, True),
        ("coulomb_friction", 0.5, True),
        ("quadratic_drag", 2e-3, False),
        ("quadratic_drag", 2e-3, True),
    ],
)
def test_the_bound_is_what_fits_state_and_how_they_scatter(term, strength, free):
    name, of_scipy = STRENGTHS[term]
    model = adopted(term, strength, free=free)
    report = predicted(model)
    bound, truth = report.windows[0].std, report.expected
    assert {n: truth[n] for n in (*MAIN, name)} == {**MAIN, name: strength}
    assert (name in bound) is free
    exact = thread_dm_dt(truth, WINDOW_S + 0.01, RATE_HZ, **{of_scipy: strength})
    noise, off = np.random.default_rng(7), []
    for _ in range(FITS):
        samples = exact + NOISE_SD[:, None] * noise.standard_normal(exact.shape)
        record = RingDownRecord(samples, RATE_HZ, "dmdt")
        fit = fit_ring_down(record, model.model, WINDOW_S, noise=NoiseModel.white(NOISE_SD, RATE_HZ))
        assert fit.verdict == "good", fit.reason
        assert {n for n, e in fit.parameters.items() if e.std is not None} == set(bound)
        for each, std in bound.items():
            assert fit.parameters[each].std == pytest.approx(std, rel=0.02), each
        off.append([fit.parameters[each].value - truth[each] for each in bound])
    apart = np.array(off)
    angle = list(bound).index("psi_start_rad")
    apart[:, angle] = (apart[:, angle] + math.pi) % (2.0 * math.pi) - math.pi
    squares = np.sum((apart / np.array(list(bound.values()))) ** 2, axis=0)
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], FITS)
    assert np.all((low < squares) & (squares < high)), dict(zip(bound, squares / FITS, strict=True))


def test_what_a_model_holds_can_be_estimated_and_is_then_as_a_free_strength():
    held, free = (adopted("coulomb_friction", 30.0, free=f) for f in (False, True))
    assert predicted(held, estimate_adopted=True).windows == predicted(free).windows
    assert predicted(held).windows[0].std["lambda_per_s"] < 0.2 * predicted(free).windows[0].std["lambda_per_s"]


def test_effects_of_the_receiver_leave_the_bound_as_it_is_and_the_notes_say_of_which_noise():
    undone = adopted("coulomb_friction", 30.0, receiver=(ReceiverEffect("gain", 0.01, axis="x"),))
    report = predicted(undone)
    assert report.windows == predicted(adopted("coulomb_friction", 30.0)).windows
    assert report.variant == "dusty@1"
    assert [note for note in report.notes or () if "gain undone" in note]
    assert [note for note in report.notes or () if "after the receiver's effects are undone" in note]


def test_expected_values_go_before_those_of_the_diagnosis_and_a_jewels_friction_is_that_of_its_file():
    model = adopted("quadratic_drag", 1e-4, base="jewel")
    report = planned_precision(JEWEL, [0.5], model=model, expected={"m_r_am2": 0.013, "quadratic_drag_per_rad": 2e-4})
    assert report.expected["m_r_am2"] == 0.013
    assert report.expected["quadratic_drag_per_rad"] == 2e-4
    assert report.expected["f_nat_hz"] == MAIN["f_nat_hz"]
    assert report.expected["tf_over_i_rad_per_s2"] == JEWEL.measured.tf_over_i_rad_per_s2


def test_what_a_declared_model_holds_is_held_in_the_bound_too():
    """A fit holds the deflection that a power law refers to; before, the bound wanted a value, and estimated it."""
    given = {"power_restoring": 1e-3, "power_restoring_exponent": 3.0}
    report = predicted("thread+power_restoring", expected=given)
    assert "power_restoring_angle_rad" in report.expected
    assert set(given) < set(report.windows[0].std)
    assert "power_restoring_angle_rad" not in report.windows[0].std


@pytest.mark.parametrize(
    ("variant", "terms", "said"),
    [
        ("dirty", (), "no variant 'dirty'.*adopted are: dusty@1"),
        ("dusty@2", (), "there is no such version"),
        ("dusty@1", ("quadratic_drag",), "takes no further terms"),
        ("dusty+quadratic_drag", (), "no variant"),
        ("thread", ("quadratic_drag", "quadratic_drag"), "name each term once"),
    ],
)
def test_a_model_that_cannot_be_is_refused_with_what_to_do(tmp_path, variant, terms, said):
    shelf = Library(tmp_path)
    shelf.add(adopted("coulomb_friction", 30.0))
    with pytest.raises(InputError, match=said) as refused:
        planned_model(variant, terms, shelf, THREAD)
    assert refused.value.remedy


def test_a_retired_model_is_no_longer_meant_by_its_name_and_one_of_the_other_bearing_is_refused(tmp_path):
    shelf = Library(tmp_path)
    shelf.add(adopted("coulomb_friction", 30.0))
    with pytest.raises(InputError, match=r"was adopted from a thread.*jewel bearing"):
        planned_model("dusty", (), shelf, JEWEL)
    shelf.retire("dusty@1", "DC", "cleaned")
    with pytest.raises(InputError, match="all its versions are retired"):
        planned_model("dusty", (), shelf, THREAD)
    again = predicted(planned_model("dusty@1", (), shelf, THREAD))
    assert "it is retired" in again.notes[0]


def test_a_drive_is_planned_for_a_manufacturing_error_alone_and_nothing_estimated_where_nothing_is_held():
    with pytest.raises(InputError, match="begins with its largest deflection"):
        predicted("thread", sequence=SequencePatch(field_t=1e-4))
    for model in ("thread", adopted("coulomb_friction", 30.0, free=True)):
        with pytest.raises(InputError, match="nothing adopted to estimate"):
            predicted(model, estimate_adopted=True)
