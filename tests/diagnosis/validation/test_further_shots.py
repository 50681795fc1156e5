"""Shots that were not searched, of which the effects lead far from the fit of the declared model."""

import pytest

from platform_daemon.diagnosis import diagnose
from platform_daemon.diagnosis.regression.per_shot_fit import per_shot_fit
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.validation.further_shots import further_shots
from platform_daemon.estimation.physics.models import THREAD
from tests.kit.undeclared_shots import shots_with

SETTLES = {"id": "frequency_drift", "strength": -0.6, "tau_s": 0.35}


@pytest.mark.long
def test_a_frequency_that_settles_explains_further_shots_as_those_that_were_searched(monkeypatch):
    """Over 4 s it turns the swing by 5 rad, from where no step of the shot's own parameters leads back."""
    (first, second, other), _ = shots_with("thread", [SETTLES], 3, rx_s=4.0)
    tested = []

    def of_shots(final, *rest):
        found = further_shots(final, *rest)
        prepared, _ = initial_fits([other], THREAD, None)
        grown = per_shot_fit(prepared[0], final.hypothesis, final.strengths)
        tested.append((found, grown[0].chi2 / prepared[0].dof))
        return found

    monkeypatch.setattr(diagnose, "further_shots", of_shots)
    found = diagnose.diagnose_shots([first, second], THREAD, further=[lambda: other])
    assert [n.candidate.effect.id for n in found.named] == ["frequency_drift"]
    ((of_further, in_parts),) = tested
    assert of_further.before > 5.0
    assert of_further.after == pytest.approx(1.0, abs=0.05)
    assert in_parts == pytest.approx(of_further.after, abs=0.02)
    assert of_further.worst == ("shot 2", pytest.approx(of_further.after))
