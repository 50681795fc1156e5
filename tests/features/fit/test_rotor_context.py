import numpy as np
import pytest

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.settings import load_specimen
from platform_daemon.design.equations import PAPER_MAGNETS, moment_of_inertia
from platform_daemon.estimation.physics.rigid_rotor.rotor import NO_DRIVE
from platform_daemon.features.fit.rotor_context import assumed_rotor_context, rotor_context, rotor_geometry
from tests.kit.acquisitions import acquire
from tests.kit.data import DATA
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


def test_what_a_recording_from_elsewhere_does_not_tell_is_assumed_and_said():
    recording = open_recording(DATA / "example_jewel.mmr.h5")
    assert rotor_context(recording, 0) is None
    assert assumed_rotor_context(recording, 0, "undamped") is None
    found = assumed_rotor_context(recording, 0, "jewel")
    drawn = rotor_geometry(load_specimen("jewel")[0])
    assert found.geometry == drawn.with_tolerances()
    assert (drawn.radius_sd_m, drawn.link_sd_m) == (0.0, 0.0)
    assert [found.geometry.radius_sd_m, found.geometry.link_sd_m] == pytest.approx([7.5e-6, 2e-5])
    assert (found.start, found.rotation) == ("free", None)
    assert found.drive_from(0.1) == NO_DRIVE
    assert ["drive" in found.assumed[0], "cup within 2 %" in found.assumed[1]] == [True, True]


def test_what_a_recording_tells_is_not_assumed(engine_with, tmp_path):
    """The second shot may begin in the swing of the first one."""
    acquire(engine_with(), tmp_path / "a.h5", window=None, shots=2)
    recording = open_recording(tmp_path / "a.h5")
    from_rest, after = (assumed_rotor_context(recording, k, "jewel") for k in range(2))
    assert (from_rest.start, after.start) == ("rest", "swing")
    assert from_rest.assumed == after.assumed == ()
