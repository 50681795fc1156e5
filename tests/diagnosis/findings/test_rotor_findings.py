"""When a rotor takes the place of effects of one angle."""

import math
from types import SimpleNamespace

import pytest

from platform_daemon.diagnosis.findings import rotor_findings
from platform_daemon.diagnosis.findings.rotor_findings import hidden_error_notes, leaves_less


@pytest.mark.parametrize(
    ("sure", "verdict", "more", "takes_it"),
    [
        # Effects that explain only a part follow the noise as well: a tie is no reason for them.
        (True, "partly_explained", 10.0, True),
        (True, "partly_explained", 11.0, False),
        (True, "explained", -5.0, False),
        (True, "explained", -11.0, True),
        # One without an error is what was declared, and effects that do not explain all may imitate its side modes.
        (False, "partly_explained", 22.0, True),
        (False, "partly_explained", 41.0, False),
        (False, "explained", -5.0, False),
        (False, "explained", -11.0, True),
    ],
)
def test_by_what_both_leave(sure, verdict, more, takes_it, monkeypatch):
    monkeypatch.setattr(rotor_findings, "chi2_beside_one_angle", lambda rotor, fit: [600.0 + more, 400.0])
    rotor = SimpleNamespace(fit=SimpleNamespace(chi2_per_dof=1.0), sure=sure, predicts=True)
    assert leaves_less(rotor, SimpleNamespace(chi2=1000.0), verdict) is takes_it
    beside_it = SimpleNamespace(fit=rotor.fit, sure=sure, predicts=False)
    assert leaves_less(beside_it, SimpleNamespace(chi2=1000.0), verdict) is (takes_it and verdict != "explained")
    noisy = replace_chi2(rotor, 1.5)
    assert not leaves_less(noisy, SimpleNamespace(chi2=1e9), verdict)


def replace_chi2(rotor, chi2_per_dof):
    return SimpleNamespace(fit=SimpleNamespace(chi2_per_dof=chi2_per_dof), sure=rotor.sure, predicts=True)


@pytest.mark.parametrize(
    ("bearing", "verdict", "said"),
    [
        ("jewel", "nothing_missing", 1),
        ("jewel", "explained", 0),
        ("thread", "nothing_missing", 0),
        (None, "nothing_missing", 0),
    ],
)
def test_where_nothing_is_missing_from_a_jewel_it_is_said_what_a_small_error_would_hide(bearing, verdict, said):
    rotor = None if bearing is None else SimpleNamespace(geometry=SimpleNamespace(bearing=bearing))
    shot = SimpleNamespace(shot=SimpleNamespace(rotor=rotor))
    fit = SimpleNamespace(
        prepared=(shot,), states=(SimpleNamespace(dynamics=SimpleNamespace(w=2.0 * math.pi * 212.0)),)
    )
    found = hidden_error_notes(fit, verdict)
    assert len(found) == said
    # The smallest drawn error that left only noise, 0.058 mm, put f_nat 0.09 Hz above the main mode.
    assert all("up to 0.6 deg" in note and "0.092 Hz above" in note for note in found)
