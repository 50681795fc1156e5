"""`${...}` in a platform file comes from the file of endpoints, or there is a clear error."""

from __future__ import annotations

import json

import pytest

from drivers.errors import ConfigError
from platform_daemon.core.settings import with_endpoints

KNOWN = {"io_cards": [{"host": "h", "command_port": 7}], "serial": {"lna": "/dev/pts/1"}}


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "endpoints.json"
    path.write_text(json.dumps(KNOWN))
    return path


def test_references_are_replaced_by_values_of_any_type_at_any_depth(file):
    tables = {"a": {"b": [{"port": "${io_cards.0.command_port}"}, "${serial.lna}"]}, "c": "no reference", "d": 1}
    found = {"a": {"b": [{"port": 7}, "/dev/pts/1"]}, "c": "no reference", "d": 1}
    assert with_endpoints(tables, file) == found


def test_a_file_without_references_needs_no_endpoints():
    assert with_endpoints({"a": "$x {y}"}, None) == {"a": "$x {y}"}


def test_a_reference_without_a_file_says_how_to_get_one():
    with pytest.raises(ConfigError, match=r"a\.b.*serial\.lna.*--endpoints"):
        with_endpoints({"a": {"b": "${serial.lna}"}}, None)


@pytest.mark.parametrize("path", ["serial.switch", "io_cards.1.host", "io_cards.x", "serial.lna.deeper"])
def test_a_reference_to_nothing_is_named(file, path):
    with pytest.raises(ConfigError, match=path):
        with_endpoints({"a": f"${{{path}}}"}, file)


@pytest.mark.parametrize("text", ["{", "not json", pytest.param("[" * 100_000, id="deep")])
def test_a_file_that_is_no_json_is_named(tmp_path, text):
    path = tmp_path / "broken.json"
    path.write_text(text)
    with pytest.raises(ConfigError, match=r"broken\.json"):
        with_endpoints({}, path)
    with pytest.raises(ConfigError, match="nowhere"):
        with_endpoints({}, tmp_path / "nowhere.json")
