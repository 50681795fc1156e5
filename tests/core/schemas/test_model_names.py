"""The names of models and torque terms, which are data, against the models themselves."""

import subprocess
import sys

import pytest

from platform_daemon.core.schemas.model_names import DECLARED_MODELS, TORQUE_TERMS, check_model_name
from platform_daemon.estimation.physics.models import MODELS, model_named
from platform_daemon.estimation.physics.torques import TERMS


def test_the_names_are_those_of_the_models_and_terms_in_their_order():
    assert list(DECLARED_MODELS) == list(MODELS)
    assert {name: tuple(term.name for term in model.terms) for name, model in MODELS.items()} == DECLARED_MODELS
    assert list(TORQUE_TERMS) == list(TERMS)
    assert {name: tuple(c.name for c in term.coefficients) for name, term in TERMS.items()} == TORQUE_TERMS


def test_the_first_coefficient_of_a_term_is_its_strength_and_the_others_are_hidden():
    hidden = {name: [c.hidden for c in term.coefficients] for name, term in TERMS.items()}
    assert all(not any(each[:1]) and all(each[1:]) for each in hidden.values())


def test_no_two_terms_have_a_coefficient_of_the_same_name():
    names = [name for term in TORQUE_TERMS.values() for name in term]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize(
    "name", ["spring", "thread+spring", "thread+viscous_damping", "jewel+quadratic_drag+quadratic_drag", ""]
)
def test_a_bad_name_is_refused_in_the_words_of_the_estimation(name):
    with pytest.raises(ValueError) as of_data:  # noqa: PT011
        check_model_name(name)
    with pytest.raises(ValueError) as of_models:  # noqa: PT011
        model_named(name)
    assert str(of_data.value) == str(of_models.value)


@pytest.mark.parametrize("name", [*DECLARED_MODELS, "thread+quadratic_drag+bias_torque"])
def test_a_good_name_is_good_for_both(name):
    check_model_name(name)
    assert model_named(name).name == name


def test_a_name_is_checked_without_the_models():
    program = (
        "import sys; from platform_daemon.features.fit.online import checked_model; checked_model('jewel', None); "
        "assert 'numba' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
