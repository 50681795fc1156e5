"""What other packages publish for us: `module:attribute` under a name, in a group of entry points."""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Any

from drivers.errors import ConfigError

BACKENDS = "platform_daemon.backends"  # drivers.platform.Backend, constructed as Backend(options)
EMULATORS = "platform_daemon.emulators"  # drivers.registry.Emulator, constructed as Emulator(tables, folder)
MEASURAND_MODELS = "platform_daemon.measurand_models"  # platform_daemon.uncertainty.curves.Curve, as Curve()
USB_BACKENDS = "platform_daemon.usb_backends"  # usb.backend.IBackend of pyusb, constructed as IBackend(host, port)


def load(group: str, name: str, kind: str) -> Any:
    """Import what is published under a name; `kind` is what a message calls it ("back end").

    Raises ConfigError if none of that name is installed, naming those that are, and if its package cannot be imported.
    """
    found = {e.name: e for e in entry_points(group=group)}
    if name not in found:
        raise ConfigError(
            f"no {kind} is called {name!r}",
            why=f"installed are: {', '.join(sorted(found)) or 'none'}",
            remedy=f"correct the name, or install the package that publishes it in the entry-point group {group}",
        )
    try:
        return found[name].load()
    except Exception as error:  # whatever the code of another package raises while it is imported
        dist = found[name].dist
        package = found[name].value if dist is None else dist.name
        raise ConfigError(
            f"the {kind} {name!r} cannot be loaded",
            where=f"package {package}",
            why=f"{found[name].value}: {type(error).__name__}: {error}",
            remedy="install what it needs, or correct or remove the package",
        ) from error
