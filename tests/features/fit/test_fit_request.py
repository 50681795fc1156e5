"""What may be asked of a fit, and what is said of its frames."""

import pytest

from drivers.errors import InputError
from platform_daemon.core.command_line.parsing import parse_values
from platform_daemon.core.schemas.fits import BLANK, unfitted
from platform_daemon.estimation.physics.models import MODELS
from platform_daemon.estimation.physics.torques import TERMS
from platform_daemon.features.fit.fit_request import FitRequest, check_fixed, without_fit
from platform_daemon.features.models.resolve import checked_variant
from tests.kit.frame_fits import good_frame


@pytest.mark.parametrize("name", MODELS)
def test_every_declared_model_can_be_asked_for(name):
    assert checked_variant(name) == name


def test_further_terms_become_part_of_the_name():
    assert checked_variant("thread", ["quadratic_drag", "bias_torque"]) == "thread+quadratic_drag+bias_torque"


@pytest.mark.parametrize(
    ("name", "terms", "word", "known"),
    [("spring", [], "spring", MODELS), ("thread", ["wind"], "wind", TERMS), ("thread+thread", [], "thread", TERMS)],
)
def test_an_unknown_name_is_answered_with_those_there_are(name, terms, word, known):
    with pytest.raises(InputError) as error:
        checked_variant(name, terms)
    for each in (*known, word):
        assert each in str(error.value)
    for other in {*MODELS, *TERMS} - {*known, word}:
        assert f" {other}," not in str(error.value)


def test_a_term_cannot_be_had_twice():
    with pytest.raises(InputError, match="twice"):
        checked_variant("thread", ["viscous_damping"])


@pytest.mark.parametrize(
    ("variant", "fixed", "possible"),
    [
        ("thread+quadratic_drag", {"quadratic_drag_per_rad": 0.0}, True),
        ("thread+restoring_anharmonicity", {"anharmonicity": -0.01}, True),
        ("thread+quadratic_drag", {"quadratic_drag_per_rad": -1.0}, False),
        ("undamped", {"lambda_per_s": 0.2}, False),
        ("jewel", {"tf_over_i_rad_per_s2": 1000.0}, True),
        ("thread", {"f_nat_hz": 0.0}, False),
    ],
)
def test_what_can_be_held_follows_from_the_model(variant, fixed, possible):
    ask = FitRequest(variant, fixed=fixed)
    if possible:
        check_fixed(ask, calibrated=True)
    else:
        with pytest.raises(InputError):
            check_fixed(ask, calibrated=True)


def test_coefficients_of_further_terms_can_be_given_by_name():
    assert parse_values(["anharmonicity=-0.01"], "--fix") == {"anharmonicity": -0.01}


def test_reasons_are_told_once_with_their_frames_and_only_if_none_is_good():
    bad = [unfitted(k, "no_signal: x") for k in (0, 2)]
    assert without_fit(bad) == ("every frame was refused", "frame 0, 2: no_signal: x")
    assert without_fit([*bad, good_frame(1)]) is None
    blank = unfitted(1, BLANK)
    assert without_fit([*bad, blank]) == ("every excited frame was refused", "frame 0, 2: no_signal: x")
    assert without_fit([blank]) == ("no frame was excited", f"frame 1: {BLANK}")
