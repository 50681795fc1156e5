"""Where the state of a platform's outputs is kept, and the name by which its devices are claimed.

The directory belongs to the account and the devices, not to a working directory; the name belongs to the devices alone.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from drivers.errors import ConfigError
from drivers.registry import PlatformSection
from platform_daemon.core.state.accounts import give_to_owner_of_parent
from platform_daemon.core.state.state_home import state_home

_ADDRESSES = {"host", "port", "command_port", "data_port", "vendor_id", "product_id", "serial", "socket", "resource"}


def devices_name(section: PlatformSection) -> str:
    """The name of the devices that let power out: the same for every account and every platform file that names them,
    whatever else the file contains."""
    tables = (section.io_card, section.power_amplifier, section.tx_rx_switch)
    addresses = [[table.backend, *_addresses(table.options())] for table in tables]
    if not any(len(each) > 1 for each in addresses):  # devices without a wire of their own go by the platform's name
        addresses.append([section.name])
    return f"{section.power_amplifier.backend}-{hashlib.sha256(json.dumps(addresses).encode()).hexdigest()[:12]}"


def state_dir_of(section: PlatformSection) -> Path:
    """The folder of these devices, made if missing: `$XDG_STATE_HOME/platform-daemon/NAME`, `~/.local/state/...`
    without it.

    What root makes in the folder of another account belongs to that account.  Raises ConfigError if it cannot be made.
    """
    try:
        home = state_home()
        home.mkdir(parents=True, exist_ok=True, mode=0o700)
        state_dir = home / "platform-daemon" / devices_name(section)
        for folder in (state_dir.parent, state_dir):
            folder.mkdir(exist_ok=True, mode=0o700)
            give_to_owner_of_parent(folder)
    except (OSError, RuntimeError) as error:  # RuntimeError: the account has no home
        why = getattr(error, "strerror", None) or str(error)
        remedy = "set XDG_STATE_HOME to a folder that this account may write, the same one for every command"
        raise ConfigError("the state of the outputs cannot be kept", where="state", why=why, remedy=remedy) from None
    return state_dir


def _addresses(value: Any, key: str = "") -> Iterator[str]:
    """All entries of a table that say where a device is, in order."""
    if isinstance(value, dict):
        for name in sorted(value):
            yield from _addresses(value[name], name)
    elif isinstance(value, list):
        for each in value:
            yield from _addresses(each, key)
    elif key in _ADDRESSES:
        yield f"{key}={value}"
