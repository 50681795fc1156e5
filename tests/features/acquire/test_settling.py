import math

import pytest

from drivers.specimen import Measured
from platform_daemon.core.hardware.catalogue import Damping
from platform_daemon.core.settings import load_sequence, load_specimen
from platform_daemon.features.acquire.settling import remaining_amplitude, settling
from sequences.compiler import compile_shot
from sequences.request import SequenceRequest
from tests.kit.transmit_side import side

THREAD, JEWEL = load_specimen("thread")[0], load_specimen("jewel")[0]


def check(specimen, **keys):
    request = SequenceRequest(**{**load_sequence(specimen.variant).model_dump(), **keys})
    return settling(compile_shot(request, side()), specimen, 0.03)


def test_after_the_papers_15_s_the_thread_still_swings_at_2_5_percent_which_is_no_warning():
    found = check(THREAD)
    assert found.share == pytest.approx(0.0247, abs=2e-4)
    assert found.warning is None


def test_a_shorter_window_warns_with_what_remains_and_the_remedy():
    found = check(THREAD, rx_s=10.0)
    assert found.share > 0.03
    assert "8." in found.warning
    assert "rx_s" in found.warning


def test_a_pause_counts_as_rest():
    assert check(THREAD, rx_s=10.0, pause_s=10.0).warning is None


def test_dry_friction_brings_the_jewel_to_rest_within_its_2_s():
    assert check(JEWEL).remaining_rad == 0.0
    assert check(JEWEL, rx_s=0.5).warning is not None


def test_viscous_decay_alone_is_the_exponential():
    assert remaining_amplitude(0.4, 0.25, 0.0, 1355.0, 4.0) == pytest.approx(0.4 * math.exp(-1.0))


def test_dry_friction_alone_decays_linearly_to_zero():
    slope = 2 * 1324.0 / (math.pi * 1340.0)
    assert remaining_amplitude(0.9, 0.0, 1324.0, 1340.0, 0.5) == pytest.approx(0.9 - 0.5 * slope)
    assert remaining_amplitude(0.9, 0.1, 1324.0, 1340.0, 5.0) == 0.0


def test_what_tune_found_counts_more_than_what_is_declared():
    plan = compile_shot(SequenceRequest(**load_sequence("thread").model_dump()), side())
    assert settling(plan, THREAD, 0.03).warning is None
    found = settling(plan, THREAD, 0.03, tuned=Damping(lambda_per_s=0.1, tf_over_i_rad_per_s2=0.0))
    assert found.share == pytest.approx(math.exp(-0.1 * 14.97), rel=0.01)
    assert "not_settled" in found.warning


def test_of_a_new_specimen_it_promises_nothing_and_says_what_to_do():
    new = THREAD.model_copy(update={"measured": Measured()})
    found = check(new, pause_s=1000.0)
    assert found.share == 1.0
    assert "run tune" in found.warning
