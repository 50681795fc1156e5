"""Numbers with their errors."""

import pytest

from platform_daemon.core.reporting.numbers import estimates_text, in_words, number
from platform_daemon.core.schemas.fits import ParameterEstimate
from platform_daemon.core.schemas.parameters import PARAMETERS


@pytest.mark.parametrize(
    ("value", "std", "factor", "text"),
    [
        (215.69031, 0.0012, 1.0, "215.6903(12)"),
        (0.0122599, 1.7e-7, 1e3, "12.25990(17)"),
        (1190.0, 12.0, 1.0, "1190(12)"),
        (0.2465, None, 1.0, "0.2465"),
        (0.2465, 0.0, 1.0, "0.2465"),
        (None, 0.1, 1.0, "-"),
    ],
)
def test_the_error_stands_in_brackets_at_the_last_two_digits(value, std, factor, text):
    assert number(value, std, factor) == text


def test_a_parameter_is_told_with_symbol_and_shown_unit():
    assert in_words(PARAMETERS["m_r_am2"], 0.0122599, 1.7e-7) == "m_r 12.25990(17) mAm²"
    assert in_words(PARAMETERS["anharmonicity"], 0.25, None) == "β 0.25"


def test_estimates_in_one_line_leave_the_orientation_out():
    found = {name: ParameterEstimate(value=0.5, std=None) for name in ("f_nat_hz", "rodrigues_x", "phi_max_rad")}
    assert estimates_text(found) == "f_nat 0.5 Hz, φ_max 28.6479 °"
