"""Fits as tables: as wide as the terminal, every text once."""

import pytest
from rich.cells import cell_len

from platform_daemon.core.schemas.fits import unfitted
from platform_daemon.core.schemas.parameters import RODRIGUES
from platform_daemon.features.fit.derived import frame_quantities, series_quantities
from platform_daemon.features.fit.fit import file_report
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.prediction_schema import PredictionReport, WindowPrecision
from platform_daemon.features.fit.report import fit_line, fit_table_text, prediction_table_text, ranges
from tests.kit.frame_fits import good_frame

JEWEL = {
    "f_nat_hz": 213.05, "m_r_am2": 0.01226, "lambda_per_s": 0.2465, "tf_over_i_rad_per_s2": 1190.0,
    "phi_max_rad": 0.917, "psi_start_rad": 3.86, "rodrigues_x": 0.0624, "rodrigues_y": -0.0157, "rodrigues_z": -1.53,
}  # fmt: skip


def report_of(*frames):
    return file_report("a.h5", FitRequest("jewel", "n50"), frames, None)


@pytest.fixture
def whole():
    return report_of(*(good_frame(k, **JEWEL) for k in range(3)), unfitted(3, "no_signal: too weak"))


def headings(text):
    rows = [line for line in text.splitlines() if line.startswith("┃")]
    return [[cell.strip() for cell in row.strip("┃").split("┃")] for row in rows]


@pytest.mark.parametrize("width", [60, 80, 120, 200])
def test_tables_are_as_wide_as_the_terminal_and_lose_no_column_and_no_digit(whole, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", str(width))
    text = fit_table_text(whole)
    drawn = [line for line in text.splitlines() if line[0] in "┏┃┡│├└"]
    assert max(map(cell_len, drawn)) <= width
    parts = headings(text)
    assert [part[0] for part in parts] == ["frame"] * len(parts)
    assert [heading for part in parts for heading in part[1:]] == [
        "f_nat / Hz", "m_r / mAm²", "λ / s⁻¹", "T_f/I / rad s⁻²", "φ_max / °", "ψ_start / °", "R / rad",
        "R² / %", "nRMSE / %", "χ²/dof",
    ]  # fmt: skip
    assert text.count("(0.0624, -0.0157, -1.5300)") == 4  # three frames and their mean
    assert "…" not in text


def test_a_refused_frame_is_a_row_and_its_reason_is_told(whole):
    text = fit_table_text(whole)
    assert "refused" in next(line for line in text.splitlines() if line.startswith("│") and " 3 │" in line)
    assert text.endswith("frame 3: refused: no_signal: too weak")
    assert fit_line(whole).startswith("3 of 4 frames good, f_nat 213.05 Hz, m_r 12.26 mAm²")


def test_a_report_without_a_good_frame_has_a_table_too():
    assert "refused" in fit_table_text(report_of(unfitted(0, "why")))


def test_equal_texts_are_told_once_with_their_frames_and_numbers_do_not_make_them_differ():
    said = {0: ("window_too_short: 6.8 periods",), 1: ("window_too_short: 6.9 periods",), 2: ("clipped",)}
    frames = [good_frame(k, **JEWEL).model_copy(update={"warnings": said.get(k, ("clipped",))}) for k in range(5)]
    lines = fit_table_text(report_of(*frames)).splitlines()
    assert "frame 0-1: window_too_short: 6.8 periods (numbers of frame 0)" in lines
    assert "frame 2-4: clipped" in lines


def test_frames_in_a_row_are_a_range():
    assert ranges([0, 1, 2, 5, 7, 8]) == "0-2, 5, 7-8"


def test_what_was_derived_is_told():
    signs = [(-1) ** k for k in range(6)]
    frames = [
        good_frame(
            k, **JEWEL | dict.fromkeys(RODRIGUES, 0.0) | {"f_nat_hz": 213.05 + 1e-4 * s, "rodrigues_x": 1e-3 * s}
        )
        for k, s in enumerate(signs)
    ]
    frames = [f.model_copy(update={"derived": frame_quantities("jewel", f)}) for f in frames]
    derived = series_quantities(frames, [10.0 * k for k in range(6)])
    text = fit_table_text(report_of(*frames).model_copy(update={"derived": derived}))
    assert {"Q", "Q_eq", "Q_eq to ∞"} <= {h for part in headings(text) for h in part}
    assert "│ 2715.3 │" in text  # pi f_nat / lambda
    assert "orientation error against the mean orientation 0.0573°" in text  # 1 mrad to either side
    assert "Allan deviation of f_nat: 0.000141 Hz at 10 s" in text  # sqrt(2) 0.1 mHz
    assert not any("Allan" in line for line in fit_table_text(report_of(*frames)).splitlines())


def test_a_prediction_shows_every_parameter_that_the_model_has_and_a_dash_for_those_held():
    row = WindowPrecision(window="n50", window_s=0.24, std={"quadratic_drag_per_rad": 2.4e-6}, orientation_rad=1e-4)
    found = PredictionReport(
        variant="thread+quadratic_drag", expected={"lambda_per_s": 0.1, "quadratic_drag_per_rad": 1e-4},
        noise_sd_am2_per_s=(0.1, 0.1, 0.1), sampling_rate_hz=6e4, windows=(row,),
    )  # fmt: skip
    text = prediction_table_text(found)
    assert headings(text) == [["window / s", "λ / s⁻¹", "b / rad⁻¹", "orientation / °"]]
    assert [cell.strip() for cell in text.splitlines()[-2].strip("│").split("│")] == ["0.240", "-", "2.4e-06", "0.0057"]
