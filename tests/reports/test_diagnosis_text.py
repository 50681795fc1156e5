"""A diagnosis in words."""

from platform_daemon.reports.diagnosis_text import (
    chance_text,
    effect_line,
    next_line,
    place_text,
    scientific,
    strength_text,
)

NOWHERE = dict.fromkeys(("axis", "frequency_hz", "tau_s", "sample", "from", "to"))
EFFECT = {
    "id": "quadratic_drag",
    "strength": {"value": 1.0104e-5, "std": 8.2e-8, "unit": "1/rad"},
    "detail": NOWHERE,
    "p_value": 0.0,
    "log10_p_value": -512.4,
    "held_out_gain": 5.4e5,
    "indistinguishable_from": [],
}


def test_small_and_large_numbers_come_with_their_power_of_ten():
    assert scientific(1.0104e-5, 8.2e-8) == "1.0104(82)e-5"
    assert scientific(2.5, 0.1) == "2.50(10)"
    assert scientific(0.0, None) == "0"
    assert scientific(None, None) == "-"


def test_an_effect_is_one_line_with_strength_chance_and_proof():
    line = effect_line(EFFECT)
    assert line.startswith("quadratic_drag: 1.0104(82)e-5 1/rad, p < 1e-512, held-out chi2 falls by 5.4e+05")
    assert "cannot be predicted" in effect_line(EFFECT | {"held_out_gain": None})
    assert "cannot tell it from stribeck_friction" in effect_line(
        EFFECT | {"indistinguishable_from": ["stribeck_friction"]}
    )


def test_the_unit_one_is_not_written():
    assert strength_text({"strength": {"value": 0.01, "std": 0.001, "unit": "1"}}) == "0.0100(10)"


def test_places_are_told_in_words():
    assert place_text(NOWHERE) == ""
    assert place_text(NOWHERE | {"axis": "x", "frequency_hz": 50.0}) == "on x, at 50 Hz"
    assert place_text(NOWHERE | {"from": "x", "to": "y"}) == "from x to y"
    assert place_text(NOWHERE | {"sample": 0}) == "before sample 0"
    assert place_text(NOWHERE | {"v_s_rad_per_s": 40.0}) == "v_s_rad_per_s = 40"


def test_likely_chances_are_plain():
    assert chance_text({"p_value": 0.012, "log10_p_value": -1.9}) == "p = 0.012"


def test_a_proposal_says_what_it_separates():
    text = next_line({"what": "turn it", "separates": ["a", "b"], "expected_sigma": 4.0})
    assert text == "turn it (separates a, b): 4 sigma expected"
