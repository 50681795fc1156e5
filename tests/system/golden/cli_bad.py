"""Command line: bad input is one line that says what, where, why and the remedy, and exit code 2."""

from __future__ import annotations

from tests.system.golden.cli_fits import JEWEL
from tests.system.golden.workplace import Workplace

_MEASURE = ("measure", "--resonator", "jewel", "--out", "x.h5")
_TILT = ("defects", "--bearing", "jewel", "--defect", "stator_tilt")
_JEWEL_TILT = ("defects", "--bearing", "jewel", "--defect", "jewel_tilt")
BAD: dict[str, tuple[str, ...]] = {
    "no-command": (),
    "unknown-command": ("fitt",),
    "no-file": ("fit",),
    "missing-file": ("fit", "missing.h5"),
    "no-hdf5": ("fit", "text.h5"),
    "no-recording": ("info", "text.h5"),
    "window": ("fit", JEWEL, "--window", "long"),
    "variant": ("fit", JEWEL, "--variant", "spring"),
    "term": ("fit", JEWEL, "--with-term", "magic"),
    "frames": ("fit", JEWEL, "--frames", "0,9"),
    "frames-text": ("fit", JEWEL, "--frames", "a-b"),
    "fix": ("fit", JEWEL, "--fix", "mass=1"),
    "fix-text": ("fit", JEWEL, "--fix", "lambda_per_s"),
    "resume": ("fit", JEWEL, "--resume"),
    "json-exists": ("fit", JEWEL, "--json", "there.json"),
    "json-folder": ("fit", JEWEL, "--json", "nowhere/x.json"),
    "json-is-folder": ("fit", JEWEL, "--json", "."),
    "calibration": ("fit", JEWEL, "--calibration", "text.h5"),
    "characterise-nothing": ("characterise",),
    "characterise-no-hdf5": ("characterise", "--from", "text.h5"),
    "characterise-hold": ("characterise", "--from", JEWEL, "--hold", "m_r_am2=0.01"),
    "characterise-alpha": ("characterise", "--from", JEWEL, "--alpha", "0.7"),
    "slide-window": ("slide", JEWEL, "--window", "5"),
    "slide-lambda": ("slide", JEWEL, "--lambda", "loose"),
    "slide-frame": ("slide", JEWEL, "--frame", "7"),
    "plot-frame": ("plot", JEWEL, "--frame", "7", "--png", "x.png"),
    "harmonics": ("harmonics", "missing.h5"),
    "predict-resonator": ("predict", "--resonator", "spring"),
    "predict-deflection": ("predict", "--resonator", "jewel", "--deflection-deg", "100"),
    "predict-noise": ("predict", "--resonator", "jewel", "--noise", "a,b"),
    "predict-expect": ("predict", "--resonator", "jewel", "--with-term", "quadratic_drag"),
    "design-resonator": ("design", "--resonator", "spring"),
    "defects-thread-jewel": ("defects", "--bearing", "thread", "--defect", "jewel_tilt", "--eps-deg", "1"),
    "defects-size": (*_TILT, "--dy-mm", "1"),
    "defects-no-number": (*_TILT, "--eps-deg", "nan"),
    "defects-convex": (*_TILT, "--eps-deg", "1", "--cup-radius-over-r", "-2"),
    "defects-no-rest": (*_JEWEL_TILT, "--eps-deg", "1,70", "--cup-radius-over-r", "inf"),
    "diagnose-observable": ("diagnose", JEWEL, "--observable", "colour"),
    "diagnose-missing": ("diagnose", "missing.h5"),
    "adopt-no-json": ("adopt", "text.h5", "--name", "x"),
    "adopt-no-diagnosis": ("adopt", "there.json", "--name", "x"),
    "measure-resonator": ("measure", "--resonator", "spring", "--out", "x.h5"),
    "sweep-key": ("sweep", "--resonator", "jewel", "--over", "field=1:2:1"),
    "sweep-step-0": ("sweep", "--resonator", "jewel", "--over", "field_ut=1:2:0"),
    "sweep-limit": ("sweep", "--resonator", "jewel", "--over", "field_ut=200:2000:900"),
    "tune-limit": ("tune", "--resonator", "jewel", "--field-ut", "2000"),
    "tune-weak": ("tune", "--resonator", "jewel", "--weak-field-ut", "500", "--max-field-ut", "400"),
    "ramp-limit": ("ramp", "--resonator", "thread", "--max-ut", "5000"),
    "ramp-step-0": ("ramp", "--resonator", "thread", "--step-ut", "0"),
    "ramp-start": ("ramp", "--resonator", "thread", "--start-ut", "300", "--max-ut", "200"),
    "sweep-rule": ("sweep", "--resonator", "jewel", "--over", "field_ut=200,300", "--stop-when", "phi > 1"),
    "measure-no-shots": (*_MEASURE, "--shots", "0"),
    "measure-field": (*_MEASURE, "--field-ut", "5000"),
    "measure-there": ("measure", "--resonator", "jewel", "--out", "there.json"),
    "platform": ("devices", "--platform", "nowhere"),
    "set-key": ("devices", "--set", "io_card.colour=1"),
    "set-text": ("devices", "--set", "nonsense"),
    "endpoints": ("devices", "--platform", "emulated"),
    "config-check": ("config", "check", "there.json"),
    "config-missing": ("config", "check", "nowhere.toml"),
    "calibrate-one-frequency": ("calibrate", "receive", "--out", ".", "--frequency-hz", "200"),
    "calibrate-name": ("calibrate", "transmit", "--out", ".", "--name", "../x"),
    "emulate-config": ("emulate", "--config", "nowhere.toml"),
    "serve-port": ("serve", "--port", "99999"),
    "serve-network": ("serve", "--host", "0.0.0.0"),
    "token-name": ("token", "add", "local", "--role", "viewer"),
    "token-unknown": ("token", "revoke", "ann"),
    "token-none": ("token", "list"),
}


def bad_input(place: Workplace) -> None:
    """Every entry of BAD, in one folder."""
    place.take(JEWEL)
    (place.folder / "text.h5").write_text("no hdf5")
    (place.folder / "there.json").write_text("{}")
    for name, arguments in BAD.items():
        place.case(name, *arguments)
