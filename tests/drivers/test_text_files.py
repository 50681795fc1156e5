"""Text files that were saved on Windows."""

from __future__ import annotations

import codecs
from pathlib import Path

import pytest

from drivers.errors import ConfigError
from drivers.text_files import read_text_file
from platform_daemon.core.settings import load_platform, read_toml, shipped


def test_a_byte_order_mark_and_line_ends_of_windows_are_no_text(tmp_path: Path) -> None:
    """Case 09: what Windows saves."""
    path = tmp_path / "a.toml"
    path.write_bytes(codecs.BOM_UTF8 + 'a = "Łódź"\r\nb = 2\r\n'.encode())
    assert read_text_file(path) == 'a = "Łódź"\nb = 2\n'
    assert read_toml(path)[0] == {"a": "Łódź", "b": 2}


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_another_encoding_is_named(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes("a = 1\n".encode(encoding))
    with pytest.raises(ConfigError, match=r"the file is in UTF-(16|32): save it as UTF-8"):
        read_toml(path)


def test_latin_1_is_told_by_its_byte(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes("a = 'µ'\n".encode("latin-1"))
    with pytest.raises(ConfigError, match="byte 5 is not UTF-8"):
        read_toml(path)


def test_platform_files_and_endpoints_are_read_with_it(tmp_path: Path) -> None:
    path, endpoints = tmp_path / "platform.toml", tmp_path / "endpoints.json"
    path.write_bytes(codecs.BOM_UTF8 + shipped("platforms")["simulated"].read_bytes())
    endpoints.write_bytes(codecs.BOM_UTF8 + b"{}")
    assert load_platform(path, (), endpoints) is not None
