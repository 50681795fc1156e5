"""Command line: the simulated and the emulated platform."""

from __future__ import annotations

import signal
import subprocess
import time

from tests.system.golden.workplace import TIMEOUT_S, Workplace

# The simulated world at a fixed time, with a thermometer whose readings do not depend on how often it is read.
FIXED = ("--set", "backends.simulated.clock.start_utc=2026-01-01T00:00:00Z",
         "--set", "backends.simulated.thermometer.noise_k=0.0")  # fmt: skip
SHORT_JEWEL = ("--resonator", "jewel", "--rx-s", "0.6")


def series(place: Workplace) -> None:
    """`measure` and what can be done with its recordings."""
    place.case("measure", "measure", *SHORT_JEWEL, "--shots", "3", "--blank-shots", "1", "--sample", "S-1",
               "--operator", "me", "--comment", "golden", "--out", "jewel.mmr.h5", "--json", "measure.json",
               *FIXED)  # fmt: skip
    place.keep_structure("measure-structure", place.folder / "jewel.mmr.h5")
    place.case("measure-blank", "measure", "--resonator", "thread", "--shots", "0", "--blank-shots", "1", "--rx-s",
               "0.3", "--out", "blank.h5", "--json", "blank.json", *FIXED)  # fmt: skip
    place.case("measure-failed", "measure", *SHORT_JEWEL, "--shots", "2", "--out", "failed.h5", "--json", "failed.json",
               "--set", "backends.simulated.faults.card_timeout=[2]", *FIXED)  # fmt: skip
    place.case("measure-discarded", "measure", *SHORT_JEWEL, "--shots", "2", "--out", "discarded.h5",
               "--json", "discarded.json", "--set", "backends.simulated.faults.lost_steps=[1]", *FIXED)  # fmt: skip
    place.case("info", "info", "jewel.mmr.h5", "--json", "info.json")
    place.case("fit", "fit", "jewel.mmr.h5", "--derived", "--json", "fit.json")
    place.case("fit-n50", "fit", "jewel.mmr.h5", "--window", "n50", "--frames", "1,3", "--json", "fit-n50.json")
    place.case("fit-blank", "fit", "blank.h5", "--json", "fit-blank.json")
    place.case("slide", "slide", "jewel.mmr.h5", "--frame", "1", "--window", "0.1", "--json", "slide.json")
    place.case("harmonics", "harmonics", "jewel.mmr.h5", "--json", "harmonics.json")


def platform(place: Workplace) -> None:
    """`devices`, `calibrate`, `bench fit`, `reset-amplifier`, `config check`, `sweep`, `tune`."""
    place.case("sweep", "sweep", *SHORT_JEWEL, "--over", "field_ut=200:400:100", "--over", "tx_periods=8,10",
               "--pause-s", "20", "--output", "sweep.h5", "--json", "sweep.json", *FIXED)  # fmt: skip
    place.keep_structure("sweep-structure", place.folder / "sweep.h5")
    place.case("sweep-plan", "sweep", *SHORT_JEWEL, "--over", "rx_ms=300:600:100", "--shots", "2", "--dry-run",
               "--json", "plan.json")  # fmt: skip
    place.case("tune", "tune", "--resonator", "jewel", "--presets", "presets", "--output", "tune.h5", "--json",
               "tune.json", *FIXED)  # fmt: skip
    place.case("tune-plan", "tune", "--resonator", "thread", "--max-field-ut", "300", "--dry-run", "--json",
               "tune-plan.json")  # fmt: skip
    place.case("info-sweep", "info", "sweep.h5", "--json", "info-sweep.json")
    place.case("devices", "devices", "--json", "devices.json", *FIXED)
    two = ("--frequency-hz", "200", "--frequency-hz", "600", "--repetitions", "2", "--out", "calibrations")
    place.case("calibrate-receive", "calibrate", "receive", *two, "--json", "receive.json", *FIXED)
    place.case("calibrate-transmit", "calibrate", "transmit", *two, "--name", "lab", "--json", "transmit.json", *FIXED)
    for path in sorted((place.folder / "calibrations").glob("*.h5")):
        place.keep_structure(f"calibration-{path.name.partition('@')[0]}", path)
        place.case(f"info-{path.name.partition('@')[0]}", "info", path.relative_to(place.folder))
    few = ("--repeats", "3", "--paper-s", "0", "--shots", "0", "--no-processes")
    place.case("bench", "bench", "fit", *few, "--json", "bench.json", told=False)
    place.case("self-test", "self-test", "--json", "self-test.json", *FIXED)
    place.case("reset-amplifier", "reset-amplifier", *FIXED)
    config = place.tree / "config"
    for name in ("platforms/simulated", "resonators/jewel", "sequences/thread"):
        place.case(f"config-check-{name.replace('/', '-')}", "config", "check", config / f"{name}.toml")


def emulated(place: Workplace) -> None:
    """`emulate` and the devices behind its wires."""
    target, config = place.folder / "endpoints.json", place.tree / "config"
    # Its world goes on in real time: the temperature would depend on the moment.
    text = (config / "emulators/lab.toml").read_text().replace('"../', f'"{config}/')
    (place.folder / "lab.toml").write_text(f"{text}\n[world.effects.temperature]\nenabled = false\n")
    process = subprocess.Popen(
        place.command("emulate", "--config", "lab.toml", "--json", target.name),
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=place.folder, env=place.environment,
    )  # fmt: skip
    try:
        end = time.monotonic() + TIMEOUT_S
        while not target.exists() and process.poll() is None and time.monotonic() < end:
            time.sleep(0.02)
        place.keep("endpoints.json", target.read_text())
        there = ("--platform", "emulated", "--endpoints", target.name)
        place.case("devices", "devices", *there, "--json", "devices.json")
        place.case("config-check", "config", "check", config / "platforms/emulated.toml", *there[2:])
    finally:
        process.send_signal(signal.SIGTERM)
        told, complained = process.communicate(timeout=30)
    place.keep("emulate.stdout.json", told)
    place.keep("emulate.txt", f"exit code {process.returncode}\n{complained}")
