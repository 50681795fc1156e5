import pytest

from drivers.errors import ConfigError
from drivers.validation import validated
from platform_daemon.core.settings import load_sequence
from sequences.request import SequenceRequest

GOOD = load_sequence("thread").model_dump()


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("rx_s", 0),
        ("rx_s", "15 s"),
        ("field_t", "215 uT"),
        ("field_t", float("nan")),
        ("field_t", -1e-6),
        ("tx_periods", 9.964),
        ("tx_periods", 0),
        ("axis", "u"),
        ("axis", [0, 0, 0]),
        ("axis", [1e200, 1e200, 0]),
        ("f_tx_hz", 1e-320),
        ("axis", [0, float("inf"), 0]),
        ("guard_samples", 0),
        ("switch_s", 0),
        ("repetitions", -1),
        ("field_ut", 215),
    ],
)
def test_a_wrong_value_is_refused_and_named(key, value):
    with pytest.raises(ConfigError) as caught:
        validated(SequenceRequest, GOOD | {key: value}, "my.toml")
    assert key in str(caught.value)
    assert caught.value.where == "my.toml"
    assert caught.value.remedy


def test_a_missing_key_is_named():
    with pytest.raises(ConfigError, match=r"'rx_s' is missing"):
        validated(SequenceRequest, {k: v for k, v in GOOD.items() if k != "rx_s"}, "my.toml")


def test_direction_vectors_are_normalised():
    assert SequenceRequest(**GOOD | {"axis": (0.0, 3.0, 4.0)}).direction().tolist() == [0.0, 0.6, 0.8]
