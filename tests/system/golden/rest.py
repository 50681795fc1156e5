"""REST: every route of the daemon on the simulated platform; none may be without a case."""

from __future__ import annotations

from tests.kit.stored_jobs import job_texts
from tests.system.golden.cli_diagnoses import HIDDEN
from tests.system.golden.daemon import Daemon
from tests.system.golden.workplace import Workplace

JEWEL, SWING = "example_jewel.mmr", "r2_rotary_pendulum_run1"
SHOT = {"resonator": "jewel", "sequence": {"rx_s": 0.6}}
THREAD = {"resonator": "thread", "sequence": {"rx_s": 1.0}}


class RouteWithoutCase(AssertionError):
    """A route of the live schema that no case asks for."""


def routes(place: Workplace) -> None:
    """Every route; the last thing kept is the list of routes.  Raises RouteWithoutCase."""
    place.take(f"{JEWEL}.h5", f"measured/{SWING}.h5", into="data/recordings")
    (place.folder / "data/recordings/broken.h5").write_bytes(b"no hdf5")
    with Daemon(place, *HIDDEN) as daemon:
        _platform(daemon)
        _catalogue(daemon)
        made = _acquisitions(daemon)
        _recordings(daemon, made)
        _fits(daemon, made)
        _predictions(daemon)
        _design(daemon)
        _diagnoses(daemon)
        _characterisations(daemon, made)
        _reproductions(daemon)
        _calibrations(daemon)
        _problems(daemon)
        _procedures(daemon)
        _schedules(daemon)
        _self_tests(daemon)
        _cancelled(daemon)
        asked = daemon.routes()
    place.keep("routes.txt", "\n".join(asked) + "\n")
    for folder in ("fits", "diagnoses", "models"):
        for path in sorted((place.folder / "data" / folder).rglob("*.json"), key=lambda p: p.stat().st_mtime_ns):
            place.keep(f"data/{folder}/{path.name}", path.read_text())
    _journal(place)
    missing = [route for route, met in asked.items() if not met]
    if missing:
        raise RouteWithoutCase(f"no case asks for {', '.join(missing)}: add one to tests/system/golden/rest.py")


def _platform(daemon: Daemon) -> None:
    for name in ("", "health", "ready", "platform", "devices", "resonators", "models"):
        daemon.ask(f"platform/{name or 'root'}", "GET", f"/{name}")
    for name in ("acquisitions", "calibrations", "fits", "diagnoses", "characterisations"):
        daemon.ask(f"platform/no-{name}", "GET", f"/{name}")
    daemon.ask("platform/alarms", "GET", "/alarms")
    daemon.ask("platform/no-alarm", "POST", "/alarms/nothing/acknowledge", json={"by": "me"})
    daemon.ask("platform/metrics", "GET", "/metrics")
    daemon.ask("platform/caller", "GET", "/caller")
    daemon.ask("platform/no-jobs", "GET", "/jobs")
    daemon.ask("platform/no-measurands", "GET", "/measurands")
    daemon.ask("platform/no-measurand", "GET", "/measurands/nobody")
    daemon.ask("platform/no-sensor", "POST", "/measurands", json={"specimen": "jewel", "schedule": "nightly"})
    daemon.ask("platform/specimens", "GET", "/specimens")
    daemon.ask("platform/no-specimen", "GET", "/specimens/nobody")
    daemon.ask("platform/no-baseline", "POST", "/specimens/nobody/baseline", json={"by": "me", "reason": "new"})
    for part in ("", "/picture", "/table"):
        daemon.ask(f"platform/no-trend{part.replace('/', '-')}", "GET", f"/specimens/nobody/trend{part}")
    daemon.ask("platform/events-number", "GET", "/events", params={"after": "x"})
    daemon.ask("platform/queue", "POST", "/platform/queue", json={"order": ["nothing"]})
    daemon.ask("platform/mounted", "GET", "/platform/resonator")
    daemon.ask("platform/mount", "POST", "/platform/resonator", json={"resonator": "jewel", "by": "me"})
    daemon.ask("platform/no-live", "GET", "/live/harmonics")
    daemon.ask("platform/reset", "POST", "/devices/power_amplifier/reset", json={})
    daemon.ask("platform/fault-reset", "POST", "/platform/fault/reset", json={"by": "me", "reason": "looked"})


def _catalogue(daemon: Daemon) -> None:
    thread = daemon.ask("catalogue/thread", "GET", "/resonators/thread")
    for kind, body in (("resonators", thread), ("sequences", {"rx_s": 0.6})):
        daemon.ask(f"catalogue/add-{kind}", "POST", f"/{kind}", params={"name": "own"}, json=body)
        daemon.ask(f"catalogue/own-{kind}", "GET", f"/{kind}/own@1")
        daemon.ask(f"catalogue/{kind}", "GET", f"/{kind}")
    daemon.ask("catalogue/dry-run", "POST", "/acquisitions/dry-run", json={"resonator": "own", "preset": "own"})


def _acquisitions(daemon: Daemon) -> str:
    plan = {**SHOT, "shots": 2, "blank_shots": 1, "operator": "me", "sample": "S-1", "comment": "golden"}
    daemon.ask("acquisitions/dry-run", "POST", "/acquisitions/dry-run", json=plan)
    daemon.ask("acquisitions/dry-run-thread", "POST", "/acquisitions/dry-run", json={"resonator": "thread"})
    made = daemon.job("acquisitions/jewel", "/acquisitions", plan)
    daemon.job("acquisitions/no-fit", "/acquisitions", {**SHOT, "window": None})
    daemon.job("acquisitions/blank", "/acquisitions", {**SHOT, "shots": 0, "blank_shots": 1})
    ended = made["links"]["self"]
    daemon.ask("acquisitions/shots", "GET", f"{ended}/shots")
    daemon.ask("acquisitions/change-ended", "PUT", ended, json=SHOT)
    for name in ("pause", "resume"):
        daemon.ask(f"acquisitions/{name}-ended", "POST", f"{ended}/{name}", json={})
    daemon.ask("acquisitions/live", "GET", "/live/harmonics")
    daemon.ask("acquisitions/all", "GET", "/acquisitions")
    daemon.settle()
    daemon.ask("acquisitions/platform-after", "GET", "/platform")
    return str(made["result"]["recording"])


def _recordings(daemon: Daemon, made: str) -> None:
    daemon.ask("recordings/all", "GET", "/recordings")
    for name, identifier in (("made", made), ("example", JEWEL), ("angles", SWING), ("broken", "broken")):
        daemon.ask(f"recordings/{name}", "GET", f"/recordings/{identifier}")
    frame = f"/recordings/{made}/frames/1"
    daemon.ask("recordings/recover", "POST", "/recordings/recover", json={})
    daemon.ask("recordings/file", "GET", f"/recordings/{JEWEL}/file")
    daemon.ask("recordings/dmdt", "GET", f"{frame}/dmdt", params={"points": 50})
    daemon.ask("recordings/dmdt-part", "GET", f"{frame}/dmdt", params={"points": 9, "start_s": 0.1, "stop_s": 0.11})
    daemon.ask("recordings/dmdt-npy", "GET", f"{frame}/dmdt", params={"format": "npy"})
    daemon.ask("recordings/dmdt-h5", "GET", f"{frame}/dmdt", params={"format": "h5", "stop_s": 0.1})
    daemon.ask("recordings/npy-file", "GET", f"{frame}/dmdt.npy", params={"start_s": 0.1})
    daemon.ask("recordings/h5-file", "GET", f"{frame}/dmdt.h5", params={"stop_s": 0.1})
    daemon.ask("recordings/dmdt-frame", "GET", f"/recordings/{made}/frames/9/dmdt")
    daemon.ask("recordings/dmdt-span", "GET", f"{frame}/dmdt", params={"start_s": 3.0})
    daemon.ask("recordings/sliding", "GET", f"{frame}/sliding", params={"window_s": 0.15, "lambda": "free"})
    daemon.ask("recordings/sliding-long", "GET", f"{frame}/sliding", params={"window_s": 50.0})
    daemon.ask("recordings/harmonics", "GET", f"{frame}/harmonics")
    daemon.ask("recordings/picture", "GET", f"{frame}/picture")
    daemon.ask("recordings/plot", "GET", f"{frame}/plot", params={"points": 40})
    daemon.ask("recordings/f32-file", "GET", f"{frame}/dmdt.f32", params={"stop_s": 0.1})
    daemon.ask("recordings/budget", "GET", f"/recordings/{JEWEL}/budget")
    daemon.ask("recordings/budget-picture", "GET", f"/recordings/{JEWEL}/budget/picture")
    daemon.ask("recordings/no-measurand", "GET", f"/recordings/{JEWEL}/measurand")
    daemon.ask("recordings/changes", "GET", "/changes", params={"limit": 1})
    daemon.ask("recordings/harmonics-example", "GET", f"/recordings/{JEWEL}/frames/0/harmonics")


def _fits(daemon: Daemon, made: str) -> None:
    fit = daemon.job("fits/jewel", "/fits", {"recording": made})["links"]["self"]
    daemon.job("fits/n50", "/fits", {"recording": JEWEL, "window": "n50", "frames": [1]})
    fixed = {"fixed": {"lambda_per_s": 0.2465}, "hints": {"tf_over_i_rad_per_s2": 1190.0}}
    daemon.job("fits/fixed", "/fits", {"recording": JEWEL, "window": 0.2, **fixed})
    daemon.job("fits/term", "/fits", {"recording": JEWEL, "window": 0.3, "terms": ["quadratic_drag"]})
    swing = daemon.job("fits/angles", "/fits", {"recording": SWING, "variant": "jewel_constant_friction"})
    refused = daemon.job("fits/refused", "/fits", {"recording": SWING})["links"]["self"]
    daemon.ask("fits/derived", "GET", f"{fit}/derived")
    daemon.ask("fits/derived-angles", "GET", f"{swing['links']['self']}/derived")
    daemon.ask("fits/derived-refused", "GET", f"{refused}/derived")
    daemon.ask("fits/envelopes", "GET", f"{fit}/frames/1/envelopes", params={"points": 20})
    daemon.ask("fits/envelopes-blank", "GET", f"{fit}/frames/0/envelopes")
    daemon.ask("fits/all", "GET", "/fits")
    daemon.ask("fits/cancel-ended", "DELETE", fit)


def _schedules(daemon: Daemon) -> None:
    far = {"name": "far", "trigger": {"at": ["2099-01-01T08:00"], "time_zone": "Europe/Berlin"}}
    asked = {**far, "work": {"kind": "acquisition", "request": SHOT}}
    daemon.ask("schedules/preview", "POST", "/schedules/preview", json=asked)
    made = f"/schedules/{daemon.ask('schedules/add', 'POST', '/schedules', json=asked)['id']}"
    daemon.ask("schedules/all", "GET", "/schedules")
    daemon.ask("schedules/one", "GET", made)
    for what in ("pause", "resume"):
        daemon.ask(f"schedules/{what}", "POST", f"{made}/{what}", json={})
    daemon.settle()
    daemon.ask("schedules/run", "POST", f"{made}/run", json={}, racing=True)
    daemon.ask("schedules/remove", "DELETE", made)
    daemon.ask("schedules/ledger", "GET", f"{made}/ledger", params={"after": 1000})
    daemon.ask("schedules/never", "POST", "/schedules", json={**asked, "trigger": {"cron": "0 0 30 2 *"}})


def _predictions(daemon: Daemon) -> None:
    daemon.ask("predict/jewel", "POST", "/predict", json={"resonator": "jewel", "windows": ["n50", 1.0]})
    expected = {"terms": ["quadratic_drag"], "expected": {"quadratic_drag_per_rad": 1e-4}}
    body = {"resonator": "thread", "phi_max_rad": 0.7, "fixed": ["lambda_per_s"], **expected}
    daemon.ask("predict/thread", "POST", "/predict", json=body)


def _design(daemon: Daemon) -> None:
    daemon.ask("design/paper", "GET", "/design")
    daemon.ask("design/thread", "GET", "/resonators/thread/design")
    daemon.ask("design/own", "GET", "/resonators/own@1/design")
    tilt = {"bearing": "jewel", "defect": "jewel_tilt", "eps_deg": [0.5, 2.0], "phi_deg": [10.0, 30.0]}
    daemon.ask("design/tilt", "POST", "/defects", json=tilt)
    shift = {"bearing": "thread", "defect": "lateral", "dy_mm": [0.2], "direction": "along", "resonator": "own"}
    daemon.ask("design/lateral", "POST", "/defects", json=shift)
    daemon.ask("design/picture", "POST", "/defects/picture", json=shift)


def _diagnoses(daemon: Daemon) -> None:
    series = daemon.job("diagnoses/series-measured", "/acquisitions", {**THREAD, "shots": 3, "blank_shots": 1})
    recording = series["result"]["recording"]
    found = daemon.job("diagnoses/series", "/diagnoses", {"recordings": [recording]})["links"]["self"]
    some = {"recordings": [{"recording": recording, "frames": [1, 2]}], "variant": "thread", "observable": "dmdt"}
    daemon.job("diagnoses/frames", "/diagnoses", some)
    daemon.job("diagnoses/angles", "/diagnoses", {"recordings": [SWING], "base": "jewel_constant_friction"})
    daemon.ask("diagnoses/report", "GET", f"{found}/report")
    daemon.ask("diagnoses/cancel-ended", "DELETE", found)
    daemon.ask("diagnoses/all", "GET", "/diagnoses")
    daemon.ask("models/adopt", "POST", f"{found}/adopt", json={"name": "dry", "by": "me"})
    daemon.ask("models/adopt-bad-name", "POST", f"{found}/adopt", json={"name": "../dry", "by": "me"})
    daemon.ask("models/all", "GET", "/models")
    daemon.ask("models/one", "GET", "/models/dry")
    daemon.job("models/fit", "/fits", {"recording": recording, "variant": "dry", "frames": [1]})
    daemon.ask("models/sliding", "GET", f"/recordings/{recording}/frames/1/sliding", params={"window_s": 0.25})
    daemon.ask("models/retire", "POST", "/models/dry@1/retire", json={"reason": "tried out", "by": "me"})
    daemon.ask("models/retired", "GET", "/models/dry@1")
    daemon.ask("models/retired-newest", "GET", "/models/dry")


def _characterisations(daemon: Daemon, made: str) -> None:
    found = daemon.job("characterisations/jewel", "/characterisations", {"recording": made})["links"]["self"]
    some = {"recording": JEWEL, "frames": [1], "held_in_n50": {"lambda_per_s": 0.2465}, "alpha": 0.01}
    daemon.job("characterisations/one-shot", "/characterisations", some)
    daemon.ask("characterisations/report", "GET", f"{found}/report")
    daemon.ask("characterisations/cancel-ended", "DELETE", found)
    daemon.ask("characterisations/all", "GET", "/characterisations")


def _reproductions(daemon: Daemon) -> None:
    """Without one that measures: it takes a minute, and changes the noise of what follows."""
    nobody, one = {"thread": None, "jewel": None}, "/reproductions/x"
    daemon.ask("reproductions/all", "GET", "/reproductions")
    daemon.ask("reproductions/422-nobody", "POST", "/reproductions", json=nobody)
    daemon.ask("reproductions/404", "GET", one)
    daemon.ask("reproductions/404-report", "GET", f"{one}/report")
    daemon.ask("reproductions/404-change", "PUT", one, json={"quick": True})
    daemon.ask("reproductions/404-cancel", "DELETE", one)
    for what in ("pause", "resume"):
        daemon.ask(f"reproductions/404-{what}", "POST", f"{one}/{what}", json={})


def _calibrations(daemon: Daemon) -> None:
    short = {"frequencies_hz": [212.0, 424.0], "repetitions": 2}
    made = daemon.job("calibrations/receive", "/calibrations", {"kind": "receive", "name": "lab", **short})
    daemon.job("calibrations/transmit", "/calibrations", {"kind": "transmit", **short})
    here = made["links"]["self"]
    daemon.ask("calibrations/continue", "POST", f"{here}/continue", json={})
    daemon.ask("calibrations/change-ended", "PUT", here, json={"kind": "receive"})
    daemon.ask("calibrations/cancel-ended", "DELETE", here)
    daemon.ask("calibrations/all", "GET", "/calibrations")
    asked = {"kind": "receive", "calibration": made["result"]["calibration"]}
    daemon.ask("calibrations/adopt", "POST", "/calibrations/adopt", json=asked)
    daemon.ask("calibrations/adopt-none", "POST", "/calibrations/adopt", json={"kind": "transmit"})
    daemon.settle()
    daemon.ask("calibrations/platform-after", "GET", "/platform")
    daemon.job("calibrations/series-after", "/acquisitions", SHOT)


def _problems(daemon: Daemon) -> None:
    """404, 405, 422 and text that is no JSON; the kinds of problems."""
    unknown = (
        "nothing",
        "acquisitions/x",
        "calibrations/x",
        "self-tests/x",
        "recordings/x",
        "fits/x",
        "diagnoses/x",
        "characterisations/x",
        "models/x",
        "resonators/x/design",
    )
    for path in (*unknown, "recordings/x/file", "recordings/x/frames/0/dmdt", "fits/x/derived", "problems/x"):
        daemon.ask(f"problems/404-{path.replace('/', '-')}", "GET", f"/{path}")
    for kind in ("sequence-rejected", "unknown-id", "platform-error", "device-fault", "storage-error"):
        daemon.ask(f"problems/kind-{kind}", "GET", f"/problems/{kind}")
    daemon.ask("problems/405", "PUT", "/fits")
    headers = {"content-type": "application/json"}
    daemon.ask("problems/no-json", "POST", "/acquisitions", content=b"{", headers=headers)
    for name, (path, body) in BAD.items():
        daemon.ask(f"problems/422-{name}", "POST", f"/{path}", json=body)


def _procedures(daemon: Daemon) -> None:
    shot = {**SHOT, "sequence": {"rx_s": 0.6, "pause_s": 20.0}, "window": "n50"}
    fields = {"key": "field_ut", "start": 200, "stop": 400, "step": 100}
    rule = {"result": "phi_max_deg", "comparison": "<", "value": 40}
    sweep = {"kind": "sweep", "acquisition": shot, "over": [fields], "stop_when": rule}
    daemon.ask("procedures/dry-run", "POST", "/procedures/dry-run", json=sweep)
    made = daemon.job("procedures/sweep", "/procedures", sweep)["links"]["self"]
    for what in ("pause", "resume"):
        daemon.ask(f"procedures/{what}-ended", "POST", f"{made}/{what}", json={})
    daemon.ask("procedures/change-ended", "PUT", made, json=sweep)
    daemon.ask("procedures/cancel-ended", "DELETE", made)
    daemon.ask("procedures/all", "GET", "/procedures")
    tables = {"kind": "characterise", "acquisition": {**shot, "shots": 2}}
    daemon.ask("procedures/characterise-dry-run", "POST", "/procedures/dry-run", json=tables)
    found = daemon.job("procedures/characterise", "/procedures", tables)["links"]
    daemon.ask("procedures/report", "GET", found["report"])
    daemon.ask("procedures/no-report", "GET", f"{made}/report")
    tune = {"kind": "tune", "acquisition": {"resonator": "jewel"}, "keep": False}
    daemon.ask("procedures/tune-dry-run", "POST", "/procedures/dry-run", json=tune)
    daemon.job("procedures/tune", "/procedures", tune)
    wrong = {"kind": {**tune, "kind": "tun"}, "shots": {**tune, "acquisition": {"resonator": "jewel", "shots": 2}}}
    for name, asked in wrong.items():
        daemon.ask(f"procedures/422-tune-{name}", "POST", "/procedures", json=asked)
    bad = {"key": {**fields, "key": "field"}, "step-0": {**fields, "step": 0}, "limit": {**fields, "stop": 5000}}
    for name, axis in bad.items():
        daemon.ask(f"procedures/422-{name}", "POST", "/procedures", json={**sweep, "over": [axis]})


BAD: dict[str, tuple[str, dict[str, object]]] = {
    "resonator": ("acquisitions", {"resonator": "spring"}),
    "shots": ("acquisitions", {"resonator": "jewel", "shots": -1}),
    "shots-text": ("acquisitions", {"resonator": "jewel", "shots": "3", "window": "d40"}),
    "unknown-key": ("acquisitions", {"resonator": "jewel", "shot": 3}),
    "no-shots": ("acquisitions", {"resonator": "jewel", "shots": 0}),
    "sequence-key": ("acquisitions", {"resonator": "jewel", "sequence": {"field_ut": 490}}),
    "field": ("acquisitions", {"resonator": "jewel", "sequence": {"field_t": 5e-3}}),
    "dry-run": ("acquisitions/dry-run", {"resonator": "jewel", "sequence": {"rx_s": 0}}),
    "fit-recording": ("fits", {"recording": "../x"}),
    "fit-unknown": ("fits", {"recording": "nothing"}),
    "fit-variant": ("fits", {"recording": JEWEL, "variant": "spring"}),
    "fit-fixed": ("fits", {"recording": JEWEL, "fixed": {"mass_kg": 1.0}}),
    "fit-frames": ("fits", {"recording": JEWEL, "frames": [9]}),
    "diagnosis-empty": ("diagnoses", {"recordings": []}),
    "diagnosis-observable": ("diagnoses", {"recordings": [JEWEL], "observable": "colour"}),
    "characterisation-angle": ("characterisations", {"recording": SWING}),
    "characterisation-held": ("characterisations", {"recording": JEWEL, "held_in_n50": {"m_r_am2": 0.01}}),
    "predict": ("predict", {"resonator": "jewel", "windows": []}),
    "predict-variant": ("predict", {"resonator": "jewel", "variant": "spring"}),
    "defects": ("defects", {"bearing": "thread", "defect": "jewel_tilt", "eps_deg": [1.0]}),
    "defects-sizes": ("defects", {"bearing": "jewel", "defect": "lateral", "eps_deg": [1.0]}),
    "defects-picture": ("defects/picture", {"bearing": "jewel", "defect": "stator_tilt", "eps_deg": []}),
    "calibration-kind": ("calibrations", {"kind": "both"}),
    "calibration-frequencies": ("calibrations", {"kind": "receive", "frequencies_hz": [212.0]}),
    "adoption": ("calibrations/adopt", {"kind": "receive", "calibration": "x"}),
    "adoption-missing": ("calibrations/adopt", {"kind": "receive", "calibration": "lab@9_20260101"}),
    "retire": ("models/dry@1/retire", {}),
    "retire-unknown": ("models/wet@1/retire", {"reason": "none"}),
}


def _self_tests(daemon: Daemon) -> None:
    """After all that is measured: a shot more changes the noise of those that follow."""
    tested = daemon.job("self-tests/passed", "/self-tests", {"operator": "me"})["links"]["self"]
    daemon.ask("self-tests/all", "GET", "/self-tests")
    daemon.ask("self-tests/change-ended", "PUT", tested, json={})
    daemon.ask("self-tests/cancel-ended", "DELETE", tested)


def _cancelled(daemon: Daemon) -> None:
    """Last, because how far a cancelled series came changes the world for the next one."""
    running = daemon.ask("cancelled/running", "POST", "/acquisitions", json={**SHOT, "shots": 500}, racing=True)
    daemon.wait(running["links"]["self"], "running")
    waiting = daemon.ask("cancelled/waiting", "POST", "/acquisitions", json=SHOT)["links"]["self"]
    behind = {"kind": "receive", "frequencies_hz": [212.0, 424.0]}
    calibration = daemon.ask("cancelled/calibration-waiting", "POST", "/calibrations", json=behind)["links"]["self"]
    daemon.ask("cancelled/reset-meanwhile", "POST", "/devices/power_amplifier/reset", json={})
    daemon.ask("cancelled/adopt-meanwhile", "POST", "/calibrations/adopt", json={"kind": "receive"})
    daemon.ask("cancelled/waiting-taken-out", "DELETE", waiting)
    daemon.ask("cancelled/calibration-taken-out", "DELETE", calibration)
    daemon.ask("cancelled/cancelling", "DELETE", running["links"]["self"], racing=True)
    daemon.wait(running["links"]["self"], "cancelled")
    daemon.ask("cancelled/ended", "GET", running["links"]["self"], racing=True)
    stopped = daemon.ask("cancelled/to-stop", "POST", "/acquisitions", json={**SHOT, "shots": 500}, racing=True)
    daemon.ask("cancelled/stop", "POST", "/stop")
    daemon.wait(stopped["links"]["self"], "cancelled")


def _journal(place: Workplace) -> None:
    """Job records on disk, of jobs that ended by themselves."""
    for identifier, text in sorted(job_texts(place.folder / "data").items()):
        if '"cancelled"' not in text:
            place.keep(f"data/jobs/{identifier}.json", text)
