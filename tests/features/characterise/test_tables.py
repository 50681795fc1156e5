"""A characterisation of shots whose truths are known, and of such as cannot be characterised."""

import math

import numpy as np
import pytest

from drivers.errors import InputError, RecordingError
from platform_daemon.core.schemas.base import to_json
from platform_daemon.features.characterise.report import characterisation_text, parameter_rows
from platform_daemon.features.characterise.tables import characterisation_task, characterise, shown_shot
from platform_daemon.features.fit.batch.executors import in_this_process
from platform_daemon.features.fit.fit_request import FitSettings
from tests.kit.data import DATA
from tests.kit.ring_down_generator import Truth, rotation
from tests.kit.ring_down_series import JEWEL, jewels, write_ring_downs

SHOTS = 12


def characterised(path, held=None, alpha=0.001, tell=lambda what, share: None, **settings):
    with in_this_process() as workers:
        return characterise(characterisation_task(path, FitSettings(**settings), held, alpha), workers, tell)


@pytest.fixture(scope="module")
def truths():
    return jewels(SHOTS)


@pytest.fixture(scope="module")
def path(tmp_path_factory, truths):
    return write_ring_downs(tmp_path_factory.mktemp("characterise") / "jewels.h5", truths)


@pytest.fixture(scope="module")
def told():
    return []


@pytest.fixture(scope="module")
def report(path, told):
    return characterised(path, tell=lambda what, share: told.append((what, share)))


@pytest.mark.parametrize("name", ["f_nat_hz", "m_r_am2", "tf_over_i_rad_per_s2", "phi_max_rad"])
def test_the_means_are_those_of_the_truths(report, truths, name):
    true = np.array([truth.value(name) for truth in truths])
    for dataset in (report.n50, report.d30):
        found = dataset.parameters[name]
        assert found.mean == pytest.approx(true.mean(), abs=5.0 * found.fit_std / math.sqrt(SHOTS))
        assert found.shots == SHOTS
    assert report.d30.parameters[name].std == pytest.approx(true.std(ddof=1), rel=0.02, abs=3.0 * found.fit_std)


def test_phases_around_zero_are_no_scatter(report):
    found = report.d30.parameters["psi_start_rad"]
    assert found.std < 0.1
    assert min(found.mean, 2 * math.pi - found.mean) < 0.1


def test_the_short_window_holds_what_the_long_one_found(report):
    long, short = (dataset.parameters["lambda_per_s"] for dataset in (report.d30, report.n50))
    assert report.n50.held == {"lambda_per_s": long.median}
    assert (short.fit_std, short.median) == (None, long.median)
    assert long.median == pytest.approx(JEWEL.lambda_per_s, abs=5 * long.fit_std)
    row = next(row for row in report.comparisons if row.quantity == "lambda_per_s")
    assert "held" in row.reason
    assert any("N50 holds λ" in note for note in report.notes)


def test_a_complete_model_finds_the_same_in_both_windows(report):
    tested = [row for row in report.comparisons if row.reason is None]
    # All but lambda; the error of the orientation is larger in the shorter window, so that it is no constant.
    assert len(tested) == 6
    assert not any(row.significant for row in tested if row.quantity != "orientation_error_rad")
    assert all(row.low < 0.0 < row.high for row in tested if row.quantity != "orientation_error_rad")


def test_orientation_errors_are_angles_to_the_best_long_fit(report, truths):
    best = max(report.d30_fits.frames, key=lambda frame: frame.r2)
    reference = report.orientation_reference
    assert (reference.frame, reference.r2) == (best.frame, best.r2)
    centre = rotation(truths[best.frame].rodrigues)
    angles = [math.acos(min(1.0, (np.trace(centre.T @ rotation(t.rodrigues)) - 1) / 2)) for t in truths]
    assert report.d30.orientation_error_rad.mean == pytest.approx(np.mean(angles), rel=0.1)
    assert report.d30.orientation_error_rad.lowest == 0.0
    row = next(row for row in report.comparisons if row.quantity == "orientation_error_rad")
    assert row.shots == SHOTS - 1  # the reference has no error of its own


def test_the_uncertainty_of_a_shot_holds_scatter_and_what_the_windows_disagree_by(report, truths):
    found = {row.parameter: row for row in report.uncertainties}
    assert set(found) == set(report.d30.parameters)
    f_nat = found["f_nat_hz"]
    assert f_nat.uncertainty == pytest.approx(math.hypot(f_nat.scatter, f_nat.window_difference))
    assert (found["lambda_per_s"].window_difference, f_nat.systematic_std) == (None, None)
    for name, row in found.items():
        true = np.mean([truth.value(name) for truth in truths])
        if name != "psi_start_rad":
            assert abs(row.value - true) < 2.0 * row.uncertainty


def test_the_means_have_budgets(report):
    budgets = {each.quantity: each for each in report.mean_budgets}
    assert set(budgets) == set(report.d30.parameters)
    for name, found in budgets.items():
        over = report.d30.parameters[name]
        assert found.value == pytest.approx(over.mean)
        scatter = next(line for line in found.inputs if line.name == "scatter")
        assert scatter.u == pytest.approx(over.std / math.sqrt(SHOTS), rel=0.5)  # more where neighbours are alike
        assert pytest.approx(found.k * found.u) == found.U
    said = {each.name: each.would_add_per_unit for each in budgets["f_nat_hz"].not_declared}
    assert said["sample clock, per 1e-6 of its frequency"] == pytest.approx(213.2e-6, rel=1e-3)
    # What N50 holds, it cannot test.
    assert any("N50 holds" in each.name for each in budgets["lambda_per_s"].not_declared)
    rows = {(row["window"], row["parameter"]): row for row in parameter_rows(report)}
    assert rows["d30", "f_nat_hz"]["mean_U"] == budgets["f_nat_hz"].U
    assert rows["n50", "f_nat_hz"]["mean_U"] is None
    assert "What the mean is good for" in characterisation_text(report)


def test_quality_factors_fall_with_the_window_and_to_the_end(report):
    q = report.quality_factors
    # Dry friction takes the more of the motion the smaller it is (tab:quality_factors).
    assert q.n50.median > q.d30.median > q.infinity.median
    assert q.viscous.median == pytest.approx(math.pi * 213.2 / JEWEL.lambda_per_s, rel=0.01)


def test_the_table_of_fit_quality(report):
    for dataset, fits in ((report.n50, report.n50_fits), (report.d30, report.d30_fits)):
        r2 = [frame.r2 for frame in fits.frames]
        assert (dataset.r2.median, dataset.r2.lowest) == (pytest.approx(np.median(r2)), min(r2))
        assert dataset.chi2_per_dof.mean == pytest.approx(1.0, abs=0.02)
    assert report.n50.duration_s.mean == pytest.approx(0.24, abs=1e-4)
    assert 0.5 < report.d30.duration_s.mean < 1.2


def test_progress_never_falls_and_ends_with_the_tables(report, told):
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert list(dict.fromkeys(what for what, _ in told)) == ["D30 fits", "N50 fits", "tables"]
    assert len(told) > 2 * SHOTS


def test_the_shot_of_the_figures_is_the_median_one(report, path):
    frames = sorted(report.d30_fits.frames, key=lambda frame: frame.r2)
    assert report.shown_frame == frames[(SHOTS - 1) // 2].frame
    shot = shown_shot(characterisation_task(path, FitSettings(), None, 0.001), report)
    assert shot.model.shape == shot.measured.shape
    long, short = report.envelopes
    assert long.t_s[-1] == pytest.approx(report.receive_s)
    assert long.v_am2_per_s[0] == pytest.approx(short.v_am2_per_s[0], rel=1e-2)


def test_a_step_between_the_windows_is_found(tmp_path):
    # A second loss that the thread's model lacks makes lambda fall with time: N50 and D30 differ in every shot.
    shots = [Truth(f_nat_hz=215.0 + 0.05 * k, tf_over_i_rad_per_s2=10.0) for k in range(6)]
    path = write_ring_downs(tmp_path / "thread.h5", shots, 1.0, "thread")
    rows = {row.quantity: row for row in characterised(path).comparisons}
    assert rows["lambda_per_s"].significant
    assert rows["lambda_per_s"].difference < 0.0


def test_refused_shots_are_told_and_do_not_count(tmp_path, truths):
    path = write_ring_downs(tmp_path / "some.h5", [truths[0], None, truths[1]])
    report = characterised(path)
    assert (report.d30.good, report.d30.shots) == (2, 3)
    assert [refused.frames for refused in report.d30.refused] == [(1,)]
    assert any(note.startswith("D30: 1 of 3 shots refused: no_signal") for note in report.notes)
    assert {row.shots for row in report.comparisons if row.reason is None} == {2}


def test_a_single_shot_says_that_it_is_alone(tmp_path, truths):
    report = characterised(write_ring_downs(tmp_path / "one.h5", truths[:1]))
    assert report.d30.parameters["f_nat_hz"].std is None
    assert all(row.significant is None for row in report.comparisons)
    assert any("one good shot has no scatter" in note for note in report.notes)
    assert any("its own reference" in note for note in report.notes)
    assert "NaN" not in to_json(report)


def test_no_good_shot_at_all_is_said_in_words(tmp_path):
    report = characterised(write_ring_downs(tmp_path / "none.h5", [None, None]))
    assert report.n50.r2 is report.d30.r2 is report.orientation_reference is report.shown_frame is None
    assert report.d30.parameters == {}
    assert report.envelopes == ()
    assert any("no good shot" in note for note in report.notes)
    assert [row.quantity for row in report.comparisons] == ["orientation_error_rad"]


def test_without_a_calibration_neither_moment_nor_orientation(tmp_path, truths):
    path = write_ring_downs(tmp_path / "volts.h5", truths[:2], **{"/calibration/sensitivity": None})
    report = characterised(path)
    assert report.calibration is report.orientation_reference is report.d30.orientation_error_rad is None
    assert "m_r_am2" not in report.d30.parameters
    assert report.d30.parameters["f_nat_hz"].shots == 2
    assert report.envelopes == ()
    assert any(note.startswith("no calibration") for note in report.notes)


def test_a_window_cut_short_is_told(tmp_path, truths):
    report = characterised(write_ring_downs(tmp_path / "short.h5", truths[:2], 0.5))
    assert any("D30 is that window" in note for note in report.notes)


def test_a_loss_of_ones_own_is_held(path):
    report = characterised(path, held={"lambda_per_s": 0.3}, frames=(0, 1))
    assert report.n50.held == {"lambda_per_s": 0.3}
    assert report.n50.parameters["tf_over_i_rad_per_s2"].mean < report.d30.parameters["tf_over_i_rad_per_s2"].mean
    assert any("as requested" in note for note in report.notes)


@pytest.mark.parametrize(
    ("held", "frames", "said"),
    [
        ({"m_r_am2": 0.01}, None, "no loss"),
        ({"lambda_per_s": 0.2, "tf_over_i_rad_per_s2": 1000.0}, None, "no loss is left"),
        ({"lambda_per_s": -1.0}, None, "makes no sense"),
        (None, (SHOTS,), "does not exist"),
    ],
)
def test_what_cannot_be_asked_is_refused_before_any_fit(path, held, frames, said):
    with pytest.raises(InputError, match=said):
        characterisation_task(path, FitSettings(frames=frames), held, 0.001)


def test_an_angle_is_no_recording_of_a_resonator():
    with pytest.raises(RecordingError, match="time series"):
        characterisation_task(DATA / "measured" / "r5_hung_rod_a.h5", FitSettings(), None, 0.001)


def test_it_ends_when_it_is_asked_to(path):
    class EnoughError(Exception):
        pass

    def tell(what, share):
        if share > 0.1:
            raise EnoughError

    with pytest.raises(EnoughError):
        characterised(path, tell=tell)
