import pytest

from tests.campaigns.accuracy import judge, record


@pytest.mark.parametrize("chain", [pytest.param("ideal", marks=pytest.mark.campaign), "non_ideal"])
@pytest.mark.long
@pytest.mark.parametrize(("variant", "shots"), [("jewel", 20), ("thread", 8)])
def test_fits_of_simulated_shots_are_true_within_their_errors(tmp_path, variant, shots, chain):
    found = judge(record(variant, chain, shots, tmp_path / "a.h5", seed=2), chain)
    assert found.joint_below() >= shots - 1
    assert min(found.within().values()) >= shots - 1
    assert abs(found.chi2_per_dof.mean() - 1) < 0.01
    assert abs(found.pulls.mean(axis=0)).max() < 4.5 / shots**0.5


@pytest.mark.long
def test_leaving_the_frequency_response_out_biases_the_moment_by_several_sigma(tmp_path):
    found = judge(record("jewel", "non_ideal", 4, tmp_path / "a.h5"), "uncorrected", corrected=False)
    assert abs(found.pulls[:, found.names.index("m_r_am2")].mean()) > 3


@pytest.mark.campaign
@pytest.mark.parametrize("chain", ["ideal", "non_ideal"])
@pytest.mark.parametrize("variant", ["jewel", "thread"])
def test_a_hundred_shots_keep_their_joint_and_single_intervals(tmp_path, variant, chain):
    found = judge(record(variant, chain, 100, tmp_path / "a.h5", seed=3), chain)
    assert found.joint_below() >= 97
    assert min(found.within().values()) >= 97
