import math

import pytest

from platform_daemon.engine.settling import remaining_amplitude, settling
from platform_daemon.settings import load_sequence, load_specimen
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
