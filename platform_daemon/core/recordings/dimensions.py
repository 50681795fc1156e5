"""HDF5 dimension scales: a name and coordinates for every dimension of every data set.

With them xarray and netCDF open a file group by group without invented dimensions; a plain HDF5 reader finds a few
data sets more.  Added last, once per file: a scale attached twice, or to two dimensions of one data set, is what
those readers refuse.  A scale is looked up in the group of its data set and in those above, as netCDF does.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import h5py
import numpy as np

from .datasets import put, put_texts
from .layout import (
    CALIBRATION,
    DATA,
    ENTRY,
    EXCITATION,
    FIT,
    FRAMES,
    FREQUENCY,
    FREQUENCY_RESPONSE,
    INFLUENCES,
    RING_DOWN,
    SENSITIVITY,
    STEP,
    STEP_VALUES,
    TRANSMIT,
)

_FIT_COLUMNS = {
    "parameter_units": ("parameters",),
    "values": ("frame", "parameters"),
    "std": ("frame", "parameters"),
    "covariance": ("frame", "parameters", "parameters_2"),
}
_OTHERS = {
    DATA: ("frame", "channel", "time"),
    f"{ENTRY}/channel_names": ("channel",),
    f"{ENTRY}/devices/identity": ("role",),
    f"{EXCITATION}/axis": ("frame", "world_axis"),
    f"{EXCITATION}/current": ("frame", "output"),
    SENSITIVITY: ("channel", "world_axis"),
    f"{CALIBRATION}/sensitivity_std": ("channel", "world_axis"),
    FREQUENCY_RESPONSE: ("channel", "frequency"),
    f"{CALIBRATION}/p": ("channel", "world_axis", "frequency"),
    f"{CALIBRATION}/p_std": ("channel", "world_axis", "frequency"),
    f"{INFLUENCES}/u": ("influence",),
    f"{INFLUENCES}/type": ("influence",),
    f"{INFLUENCES}/dof": ("influence",),
    f"{INFLUENCES}/source": ("influence",),
    f"{CALIBRATION}/valid_frequency": ("bound",),
    f"{CALIBRATION}/valid_temperature": ("bound",),
    f"{TRANSMIT}/axes": ("coil",),
    f"{TRANSMIT}/frequency": ("transmit_frequency",),
    f"{TRANSMIT}/field_per_volt": ("coil", "world_axis", "transmit_frequency"),
    f"{TRANSMIT}/field_per_volt_std": ("coil", "world_axis", "transmit_frequency"),
    f"{TRANSMIT}/field_per_ampere": ("coil", "world_axis"),
    f"{TRANSMIT}/inductance": ("coil",),
    f"{TRANSMIT}/valid_frequency": ("bound",),
    f"{TRANSMIT}/valid_temperature": ("bound",),
}


def add_dimension_scales(h5: h5py.File, further_columns: Iterable[str] = ()) -> None:
    """Name the dimensions of a complete series or calibration file of this layout, open for writing.

    further_columns: groups of one-dimensional data sets with an entry per frame, if there are any beside the layout's.
    """
    columns = [name for name in (FRAMES, EXCITATION, STEP, STEP_VALUES, *further_columns) if name in h5]
    if RING_DOWN in h5:
        _share_plot_axes(h5)
        _add_entry_scales(h5[ENTRY])
    if EXCITATION in h5:
        _new_scale(h5[EXCITATION], "world_axis", "xyz")
        _new_scale(h5[EXCITATION], "output", np.arange(h5[EXCITATION]["current"].shape[1]), units="1")
    if CALIBRATION in h5:
        _add_calibration_scales(h5)
    for name in h5.get(FIT, {}):
        add_fit_scales(h5, name)
    for path, names in _dimensions(h5, columns):
        _attach(h5.get(path), names)


def add_fit_scales(h5: h5py.File, name: str) -> None:
    """Name the dimensions of one table of fits; the series has its own already."""
    fit = h5[FIT][name]
    if RING_DOWN in h5:
        fit["frame"] = h5[RING_DOWN]["frame"]
    _make_scale(fit, "parameters")
    _new_scale(fit, "parameters_2", fit["parameters"].asstr()[()])
    for column in fit:
        _attach(fit[column], _FIT_COLUMNS.get(column, ("frame",)))


def _share_plot_axes(h5: h5py.File) -> None:
    """Frame, channel and time of the plot, by further hard links, wherever else they are the coordinates."""
    plot = h5[RING_DOWN]
    for name in ("frame", "channel", "time"):
        _make_scale(plot, name)
        h5[name] = plot[name]
    for table in (FRAMES, EXCITATION):
        if table in h5:
            h5[table]["frame"] = plot["frame"]


def _add_entry_scales(entry: h5py.Group) -> None:
    _make_scale(entry["devices"], "role")
    names = entry["channel_names"]
    if names.size:
        entry.file["channel_names"] = names
        entry.file[DATA].attrs["coordinates"] = "channel_names"
    else:
        _make_scale(entry, "channel_names")  # the channels have no names: a separate dimension of length 0


def _add_calibration_scales(h5: h5py.File) -> None:
    made = h5[CALIBRATION]
    _new_scale(made, "world_axis", "xyz")
    _new_scale(made, "bound", ("from", "to"))
    if "channel" in h5:
        made["channel"] = h5["channel"]
    elif SENSITIVITY in h5:
        _new_scale(made, "channel", np.arange(len(h5[SENSITIVITY])), units="1")
    if FREQUENCY in h5:
        _make_scale(made, "frequency")
    if INFLUENCES in h5:
        _make_scale(h5[INFLUENCES], "influence")
    if TRANSMIT in h5:
        # Not its own `axes` and `frequency`: down a tree, xarray allows one length and set of labels for each name.
        table = h5[TRANSMIT]
        _new_scale(table, "coil", table["axes"].asstr()[()])
        _new_scale(table, "transmit_frequency", table["frequency"][()], units="Hz")


def _new_scale(group: h5py.Group, name: str, labels: Any, units: str | None = None) -> None:
    if units is None:
        put_texts(group, name, labels)
    else:
        put(group, name, labels, units=units)
    _make_scale(group, name)


def _make_scale(group: h5py.Group, name: str) -> None:
    group[name].make_scale(name)


def _dimensions(h5: h5py.File, columns: Iterable[str]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Path and dimensions of everything that may be in a file."""
    yield from _OTHERS.items()
    for group in columns:
        paths = (f"{group}/{name}" for name in h5[group])
        yield from ((path, ("frame",)) for path in paths if path not in _OTHERS)


def _attach(item: h5py.Dataset | h5py.Group | None, names: tuple[str, ...]) -> None:
    """Attach what fits: a table of another size is the reader's to judge, and no reason to lose a series."""
    if not isinstance(item, h5py.Dataset) or not item.shape or item.is_scale:
        return
    for name, dimension, length in zip(names, item.dims, item.shape, strict=False):
        scale = _nearest(item.parent, name)
        if scale is not None and scale.shape == (length,):
            dimension.attach_scale(scale)


def _nearest(group: h5py.Group, name: str) -> h5py.Dataset | None:
    """The scale of that name in a group or, if it has none, in the nearest group above."""
    found = group.get(name)
    if isinstance(found, h5py.Dataset) and found.is_scale:
        return found
    return None if group.name == "/" else _nearest(group.parent, name)
