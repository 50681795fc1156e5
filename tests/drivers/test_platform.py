import pytest

from drivers.errors import ConfigError
from drivers.registry import build_platform
from platform_daemon.core.settings import load_platform


def test_a_calibration_made_at_another_gain_is_refused():
    with pytest.raises(ConfigError, match=r"gain of 10, set is 40"):
        build_platform(load_platform("simulated", ["calibration.lna_gain=10.0"]).section)


def test_a_built_platform_is_quiet():
    platform = build_platform(load_platform("simulated").section)
    assert not platform.amplifier.status().can_put_out_power
    platform.close()
