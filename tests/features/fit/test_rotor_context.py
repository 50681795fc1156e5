import numpy as np
import pytest

from platform_daemon.design.equations import PAPER_MAGNETS, moment_of_inertia
from platform_daemon.features.fit.rotor_context import rotor_geometry
from tests.kit.rigid_rotors import rigid_specimen


@pytest.mark.parametrize(("name", "link_m"), [("thread", 12e-3), ("jewel", 1e-3)])
def test_geometry_is_that_of_the_drawing_and_knows_no_defect(name, link_m):
    plain, tilted = (rotor_geometry(rigid_specimen(name, defects=d)) for d in ({}, {"stator_tilt_rad": 0.1}))
    assert plain == tilted
    assert plain.bearing == name
    assert plain.link_m == pytest.approx(link_m)
    assert plain.inertia_kg_m2 == pytest.approx(moment_of_inertia(PAPER_MAGNETS))
    assert plain.stator_moment_am2 == pytest.approx(14.625e-3, rel=1e-4)
    assert np.sign(plain.friction_coefficient) == (name == "jewel")
