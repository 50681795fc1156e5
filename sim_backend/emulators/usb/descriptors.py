"""USB descriptors (USB 2.0, chapter 9.6): from the bytes a device sends to the attributes that pyusb expects."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from types import SimpleNamespace

DEVICE = 1
CONFIGURATION = 2
STRING = 3
INTERFACE = 4
ENDPOINT = 5

_DEVICE = struct.Struct("<BBHBBBBHHHBBBB")
_DEVICE_NAMES = (
    "bLength", "bDescriptorType", "bcdUSB", "bDeviceClass", "bDeviceSubClass", "bDeviceProtocol", "bMaxPacketSize0",
    "idVendor", "idProduct", "bcdDevice", "iManufacturer", "iProduct", "iSerialNumber", "bNumConfigurations",
)  # fmt: skip
_CONFIGURATION = struct.Struct("<BBHBBBBB")
_CONFIGURATION_NAMES = (
    "bLength", "bDescriptorType", "wTotalLength", "bNumInterfaces",
    "bConfigurationValue", "iConfiguration", "bmAttributes", "bMaxPower",
)  # fmt: skip
_INTERFACE = struct.Struct("<BBBBBBBBB")
_INTERFACE_NAMES = (
    "bLength", "bDescriptorType", "bInterfaceNumber", "bAlternateSetting", "bNumEndpoints",
    "bInterfaceClass", "bInterfaceSubClass", "bInterfaceProtocol", "iInterface",
)  # fmt: skip
_ENDPOINT = struct.Struct("<BBBBHB")
_ENDPOINT_NAMES = ("bLength", "bDescriptorType", "bEndpointAddress", "bmAttributes", "wMaxPacketSize", "bInterval")


@dataclass
class Interface:
    """One interface (or alternate setting) and its endpoints."""

    descriptor: SimpleNamespace
    endpoints: list[SimpleNamespace] = field(default_factory=list)


@dataclass
class Configuration:
    """A whole configuration."""

    descriptor: SimpleNamespace
    interfaces: list[Interface] = field(default_factory=list)


def device_descriptor(raw: bytes) -> SimpleNamespace:
    """The device descriptor.  Raises ValueError if it is none."""
    found = _parsed(raw, _DEVICE, _DEVICE_NAMES)
    found.bus = found.address = found.port_number = found.port_numbers = found.speed = None
    return found


def configuration(raw: bytes) -> Configuration:
    """A configuration descriptor with everything that follows it.  Raises ValueError if it is none."""
    out = Configuration(_parsed(raw, _CONFIGURATION, _CONFIGURATION_NAMES))
    out.descriptor.extra_descriptors = []
    place = raw[0]
    while place < len(raw):
        part = raw[place:]
        if len(part) < 2 or part[0] < 2:
            raise ValueError("a descriptor is cut short")
        if part[1] == INTERFACE:
            out.interfaces.append(Interface(_parsed(part, _INTERFACE, _INTERFACE_NAMES)))
        elif part[1] == ENDPOINT and out.interfaces:
            endpoint = _parsed(part, _ENDPOINT, _ENDPOINT_NAMES)
            endpoint.bRefresh = endpoint.bSynchAddress = 0
            out.interfaces[-1].endpoints.append(endpoint)
        place += part[0]
    return out


def _parsed(raw: bytes, layout: struct.Struct, names: tuple[str, ...]) -> SimpleNamespace:
    if len(raw) < layout.size:
        raise ValueError(f"a descriptor of {len(raw)} bytes is too short")
    return SimpleNamespace(**dict(zip(names, layout.unpack_from(raw), strict=True)), extra_descriptors=[])
