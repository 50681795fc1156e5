"""The shipped resonators of the paper's two windows, and the comparison with its numbers."""

import pytest

from tests.campaigns.paper_wound import PUBLISHED, compared, numbers_of_shots


def ratio(found, name):
    return found["n50", name] / found["d30", name]


@pytest.mark.long
def test_the_published_thread_differs_between_the_windows_as_the_papers_and_the_plain_one_does_not():
    (wound,), (plain,) = numbers_of_shots("thread_published", 1), numbers_of_shots("thread", 1)
    for name, paper in (("m_r_am2", 11.647 / 11.014), ("phi_max_deg", 21.8 / 22.8), ("lambda_per_s", 1.0)):
        assert ratio(wound, name) == pytest.approx(paper, abs=0.01), name
        assert ratio(plain, name) == pytest.approx(1.0, abs=0.01), name
    assert wound["d30", "f_nat_hz"] - wound["n50", "f_nat_hz"] == pytest.approx(215.69 - 215.53, abs=0.04)


def test_shots_agree_with_numbers_of_the_paper_that_are_theirs_and_not_with_others():
    numbers = [p for p in PUBLISHED["thread"] if p.window != "step"]
    sign = 0.5**0.5  # two shots one such deviation off have the paper's
    off = [sign * p.deviation * (p.name != "nrmse") for p in numbers]
    shots = [{(p.window, p.name): p.value + s * d for p, d in zip(numbers, off, strict=True)} for s in (-1, 1)]
    assert f"{2 * len(numbers) - 2} of {2 * len(numbers) - 2} agree" in compared("thread", shots)
    for shot in shots:
        shot["d30", "nrmse"] = 9.9
    told = compared("thread", shots)
    assert "d30 nrmse: 9.9 nan; 3.33 nan: differs" in told
    assert f"{2 * len(numbers) - 3} of" in told
