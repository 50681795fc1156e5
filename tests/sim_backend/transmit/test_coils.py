import numpy as np
import pytest
from scipy.constants import mu_0

from sim_backend.options import CoilOptions, CoilsOptions
from sim_backend.rotor.rotor import MU_0
from sim_backend.transmit.coils import loop_field_t, pair_field_t, sensitivity_t_per_a
from tests.kit.simulated_bench import options


def coils():
    return CoilsOptions.model_validate(options()["coils"])


def segments(radius, point, n=20000):
    """Biot-Savart by straight segments about z."""
    a = 2 * np.pi * (np.arange(n) + 0.5) / n
    at = radius * np.stack([np.cos(a), np.sin(a), 0 * a], 1)
    dl = 2 * np.pi * radius / n * np.stack([-np.sin(a), np.cos(a), 0 * a], 1)
    r = point - at
    return mu_0 / (4 * np.pi) * np.sum(np.cross(dl, r) / np.linalg.norm(r, axis=1)[:, None] ** 3, axis=0)


@pytest.mark.parametrize("point", [(0.0, 0.0, 0.0), (0.01, 0.0, 0.02), (0.03, 0.0, -0.04), (0.08, 0.0, 0.01)])
def test_loop_field_equals_biot_savart_by_segments(point):
    radial, axial = loop_field_t(0.05, point[0], point[2])
    assert [radial, 0.0, axial] == pytest.approx(segments(0.05, np.array(point)), rel=1e-6, abs=1e-12)


def test_centre_of_a_helmholtz_pair_has_the_textbook_field():
    coil = coils().x
    textbook = 0.8**1.5 * mu_0 * coil.turns / coil.radius_m
    assert pair_field_t(coil, 0, np.zeros(3)) == pytest.approx([textbook, 0, 0], rel=1e-9, abs=1e-18)


def test_shipped_coils_give_about_a_millitesla_per_ampere_along_their_axes():
    p = sensitivity_t_per_a(coils(), np.zeros(3))
    assert np.all((np.diag(p) > 0.88e-3) & (np.diag(p) < 1.1e-3))
    assert p == pytest.approx(np.diag(np.diag(p)), abs=1e-15)


def test_field_is_homogeneous_to_a_few_1e_5_within_five_millimetres():
    coil, centre = coils().x, pair_field_t(coils().x, 0, np.zeros(3))[0]
    for point in ([0.005, 0, 0], [0, 0.005, 0], [0.003, 0.003, 0.003]):
        assert pair_field_t(coil, 0, np.array(point))[0] == pytest.approx(centre, rel=2e-4)
    assert pair_field_t(coil, 0, np.array([0.02, 0, 0]))[0] != pytest.approx(centre, rel=1e-3)


def test_field_is_divergence_free_off_centre():
    coil, at, step = coils().y, np.array([0.011, 0.007, -0.013]), 1e-5
    slopes = [
        (pair_field_t(coil, 1, at + step * e)[i] - pair_field_t(coil, 1, at - step * e)[i]) / (2 * step)
        for i, e in enumerate(np.eye(3))
    ]
    assert abs(sum(slopes)) < 1e-6 * max(abs(s) for s in slopes)


def test_a_tilted_pair_tilts_its_field():
    tilted = CoilOptions.model_validate(options()["coils"]["x"] | {"axis_error_rad": [0.0, 0.0, 0.01]})
    b = pair_field_t(tilted, 0, np.zeros(3))
    assert np.arctan2(b[1], b[0]) == pytest.approx(0.01)


def test_the_field_on_the_axis_is_that_very_close_to_it_and_the_constant_is_that_of_scipy():
    assert pytest.approx(mu_0, rel=1e-9) == MU_0  # versions of CODATA differ in the tenth digit
    radial, axial = loop_field_t(0.1, 0.0, 0.03)
    assert radial == 0.0
    assert axial == pytest.approx(loop_field_t(0.1, 1e-7, 0.03)[1], rel=1e-10)
    assert axial == pytest.approx(mu_0 * 0.1**2 / (2 * (0.1**2 + 0.03**2) ** 1.5), rel=1e-9)
