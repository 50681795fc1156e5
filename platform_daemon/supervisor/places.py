"""Where the state of a platform's outputs is kept: with the account and the devices, not with a working directory."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from drivers.errors import ConfigError
from drivers.registry import PlatformSection

_ADDRESSES = {"host", "port", "command_port", "data_port", "vendor_id", "product_id", "serial", "socket", "resource"}


def place_of(section: PlatformSection) -> Path:
    """The folder of the devices that let power out, made if missing: the same for every platform file that names them,
    whatever else the file says.

    `$XDG_STATE_HOME/platform-daemon/NAME`, `~/.local/state/...` without it.  Raises ConfigError if it cannot be made.
    """
    tables = (section.io_card, section.power_amplifier, section.tx_rx_switch)
    addresses = [[table.backend, *_addresses(table.options())] for table in tables]
    if not any(len(each) > 1 for each in addresses):  # devices without a wire of their own go by the platform's name
        addresses.append([section.name])
    digest = hashlib.sha256(json.dumps(addresses).encode()).hexdigest()[:12]
    try:
        place = _state_home() / "platform-daemon" / f"{section.power_amplifier.backend}-{digest}"
        place.mkdir(parents=True, exist_ok=True, mode=0o700)
    except (OSError, RuntimeError) as error:  # RuntimeError: the account has no home
        why = getattr(error, "strerror", None) or str(error)
        remedy = "set XDG_STATE_HOME to a folder that this account may write, the same one for every command"
        raise ConfigError("the state of the outputs cannot be kept", where="state", why=why, remedy=remedy) from None
    return place


def _state_home() -> Path:
    """By the XDG base directory specification, which wants relative paths ignored.  Raises RuntimeError."""
    told = Path(os.environ.get("XDG_STATE_HOME", ""))
    return told if told.is_absolute() else Path.home() / ".local" / "state"


def _addresses(value: Any, key: str = "") -> Iterator[str]:
    """Everything in a table that says where a device is, in its order."""
    if isinstance(value, dict):
        for name in sorted(value):
            yield from _addresses(value[name], name)
    elif isinstance(value, list):
        for each in value:
            yield from _addresses(each, key)
    elif key in _ADDRESSES:
        yield f"{key}={value}"
