"""The campaign on a few shots: a complete model finds the truths within what it says of itself."""

import pytest

from tests.campaigns.characterise import characterised, print_tables, true_mean


@pytest.mark.long
def test_a_few_shots_of_a_single_axis_agree_with_their_truths(tmp_path, capsys):
    found = characterised("jewel", 4, tmp_path)
    checked = 0
    for row in found.report.uncertainties:
        true = true_mean(found, row.parameter)
        if true is not None:
            over = found.report.d30.parameters[row.parameter]
            assert abs(row.value - true) < 5.0 * over.fit_std / 2.0  # four shots
            assert abs(row.value - true) < 3.0 * row.uncertainty
            checked += 1
    assert checked == 5
    assert found.hardware_s > 4 * 2.0
    print_tables([found])
    assert capsys.readouterr().out.count("| jewel |") == 6
