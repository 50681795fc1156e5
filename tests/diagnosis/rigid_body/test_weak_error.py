"""A weak error counts as one where a rotor without it leaves surely more."""

from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from platform_daemon.diagnosis.rigid_body import defects
from platform_daemon.diagnosis.rigid_body.defects import none_leaves_more
from platform_daemon.estimation.rotor_fit.fit import RotorFitError


@dataclass(frozen=True)
class _Shot:
    values: object


class _Values:
    def __init__(self, **numbers):
        self.numbers = numbers

    def with_numbers(self, numbers):
        return _Values(**self.numbers | numbers)


@pytest.mark.parametrize(
    ("size_sd", "rises", "samples", "more", "fitted"),
    [
        # Jewel tilt of -1.061 deg of the defect study: 4.7 standard deviations, 38 of chi^2.
        (4.7, [38.0, 38.0], 1.0, True, 2),
        (4.7, [24.0], 1.0, False, 1),
        (4.7, [90.0, 24.0], 1.0, False, 2),  # the first one ended in a valley beside
        (4.7, [None, 38.0], 1.0, True, 2),
        (4.7, [38.0], 2.0, False, 1),  # half of the samples are independent of each other
        (1.4, [38.0, 38.0], 1.0, True, 2),  # that of -0.311 deg, 55 of chi^2
        (0.4, [], 1.0, False, 0),
        (4.7, [None, None], 1.0, False, 2),  # there is no such rotor
    ],
)
def test_a_weak_error_is_decided_by_a_rotor_without_it(size_sd, rises, samples, more, fitted, monkeypatch):
    seen = []

    def fit_of_none(shots, defect, _pool, **_):
        seen.append((defect, [shot.values.numbers for shot in shots]))
        rise = rises[len(seen) - 1]
        if rise is None:
            raise RotorFitError("no such rotor")
        return SimpleNamespace(total_chi2=1e4 + rise)

    monkeypatch.setattr(defects, "fit_rotor", fit_of_none)
    values = _Values(stator_tilt_rad=0.01, f_nat_hz=214.0)
    best = SimpleNamespace(
        defect="stator_tilt_rad", strength=(0.01, 0.01 / size_sd), shots=(_Shot(values),), values=(values,),
        known=(values,), total_chi2=1e4, chi2_per_dof=1.0,
    )  # fmt: skip
    assert none_leaves_more(best, samples, SimpleNamespace()) is more
    assert seen == fitted * [(None, [{"stator_tilt_rad": 0.0, "f_nat_hz": 214.0}])]
