"""U of the points of a trend: that of the recording's own budget, and for another number of shots."""

import shutil

import pytest

from platform_daemon.features.budget.work import series_budgets
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.measurement import open_measurement
from platform_daemon.features.trends.indexed import indexed_specimens, indexed_trend, update_index
from platform_daemon.features.trends.report import trend_csv, trend_text
from tests.kit.specimen_months import months


@pytest.mark.long
def test_points_have_the_u_of_their_recording_and_the_others_a_reason(measured, tmp_path):
    shutil.copy(measured / "j.h5", tmp_path / "j.h5")
    update_index(tmp_path)
    (specimen,) = indexed_specimens(tmp_path)
    months(tmp_path, 1, specimen=specimen)  # noise with a fit: no budget can be made of it
    update_index(tmp_path)
    report = indexed_trend(tmp_path, specimen, uncertainty=True)
    place = [point.recording for point in report.points].index("j")
    budgets = series_budgets(open_measurement(tmp_path / "j.h5"), FitRequest("jewel", "d30"))
    charts = {chart.quantity: chart for chart in report.charts}
    for name in ("f_nat_hz", "m_r_am2", "lambda_per_s", "rodrigues_z"):
        assert charts[name].U[place] == pytest.approx(budgets.of(name).expanded, rel=1e-6)
        assert charts[name].U[1 - place] is None
    assert charts["nrmse"].U is None
    assert any(note.startswith("U is not known of fits as those of") for note in report.notes)
    assert any("by the budget of j; not declared" in note and "static field" in note for note in report.notes)
    assert f" {charts['f_nat_hz'].U[place]:.2g} " in trend_text(report)
    rows = trend_csv(report).splitlines()
    cells = dict(zip(rows[0].split(","), rows[1 + place].split(","), strict=True))
    assert float(cells["f_nat_hz_U"]) == charts["f_nat_hz"].U[place]
    without = indexed_trend(tmp_path, specimen)
    assert all(chart.U is None for chart in without.charts)
    assert "_U" not in trend_csv(without)
