"""A diagnosis in words."""

from platform_daemon.diagnosis.report_schema import (
    DiagnosisReport,
    EffectDetail,
    EffectStrength,
    MovingParameter,
    NamedEffect,
    NextMeasurement,
    ParameterTrace,
)
from platform_daemon.features.diagnose.report import (
    chance_text,
    effect_line,
    next_line,
    place_text,
    scientific,
    strength_text,
    summary_text,
    where_line,
)
from tests.kit.diagnosis_json import diagnosis, effect

NOWHERE = EffectDetail(axis=None, frequency_hz=None, tau_s=None, sample=None, source=None, target=None)
EFFECT = NamedEffect(
    id="quadratic_drag",
    strength=EffectStrength(value=1.0104e-5, std=8.2e-8, unit="1/rad"),
    detail=NOWHERE,
    p_value=0.0,
    log10_p_value=-512.4,
    held_out_gain=5.4e5,
    indistinguishable_from=(),
    source="paper",
)


def at(**keys):
    return EffectDetail(**(NOWHERE.model_dump() | keys))


def test_small_and_large_numbers_come_with_their_power_of_ten():
    assert scientific(1.0104e-5, 8.2e-8) == "1.0104(82)e-5"
    assert scientific(2.5, 0.1) == "2.50(10)"
    assert scientific(0.0, None) == "0"
    assert scientific(None, None) == "-"


def test_an_effect_is_one_line_with_strength_chance_and_proof():
    line = effect_line(EFFECT)
    assert line.startswith("quadratic_drag: 1.0104(82)e-5 1/rad, p < 1e-512, held-out chi2 falls by 5.4e+05")
    assert "cannot be predicted" in effect_line(EFFECT.model_copy(update={"held_out_gain": None}))
    alike = EFFECT.model_copy(update={"indistinguishable_from": ("stribeck_friction",)})
    assert "cannot tell it from stribeck_friction" in effect_line(alike)


def test_a_fitted_time_constant_has_its_error():
    place = at(tau_s=0.350241, std={"tau_s": 0.00012})
    assert place_text(place) == "with a time constant of 0.35024(12) s"
    assert place_text(at(tau_s=0.081, std={"tau_s": 0.2})) == "with a time constant of 0.081 s"


def test_the_unit_one_is_not_written():
    plain = EffectStrength(value=0.01, std=0.001, unit="1")
    assert strength_text(EFFECT.model_copy(update={"strength": plain})) == "0.0100(10)"


def test_places_are_told_in_words():
    assert place_text(NOWHERE) == ""
    assert place_text(at(axis="x", frequency_hz=50.0)) == "on x, at 50 Hz"
    assert place_text(at(**{"from": "x", "to": "y"})) == "from x to y"
    assert place_text(at(sample=0)) == "before sample 0"
    assert place_text(at(v_s_rad_per_s=40.0)) == "v_s_rad_per_s = 40"


def test_likely_chances_are_plain():
    assert chance_text(EFFECT.model_copy(update={"p_value": 0.012, "log10_p_value": -1.9})) == "p = 0.012"


def test_a_proposal_says_what_it_separates():
    text = next_line(NextMeasurement(what="turn it", separates=("a", "b"), expected_sigma=4.0))
    assert text == "turn it (separates a, b): 4 sigma expected"


def moving(**keys):
    trace = ParameterTrace(
        time_s=(0.0, 1.0), amplitude_rad=(0.4, 0.3), peak_speed_rad_per_s=(4.0, 3.0), value=(0.2, 0.3), std=(0.01, 0.01)
    )
    known = {
        "name": "lambda_per_s", "p_value": 0.0, "log10_p_value": -30.6, "share": 0.994, "follows": ("amplitude",),
        "rises": True, "alike": (), "traces": (trace,),
    }  # fmt: skip
    return MovingParameter(**known | keys)


def test_a_constant_that_moves_is_one_line():
    assert where_line(moving()) == (
        "λ moves along the ring-down (p < 1e-30), it follows the amplitude (rises as the swing dies); "
        "it accounts for 99.4 % of the misfit"
    )
    line = where_line(moving(name="zero_offset_rad", follows=("time",), rises=False, log10_p_value=-3.1, p_value=8e-4))
    assert line.startswith("zero_offset_rad moves along the ring-down (p = 0.0008), it follows the time (falls as time")
    assert "the amplitude or the peak speed" in where_line(moving(follows=("amplitude", "speed")))
    assert "by no simple law" in where_line(moving(follows=()))
    assert where_line(moving(alike=("m_r_am2",))).endswith("m_r would do as well")


def test_it_stands_before_any_name():
    report = DiagnosisReport.model_validate(diagnosis(effect("coulomb_friction", 1.0)) | {"where": [moving()]})
    lines = summary_text(report).splitlines()
    assert lines[1].startswith("where: λ moves")
    assert lines[2].strip().startswith("coulomb_friction")
