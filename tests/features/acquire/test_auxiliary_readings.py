"""Voltages are measured, a temperature is looked at: a thermometer that fails costs a warning, and no shot."""

from __future__ import annotations

import socketserver
import threading
from contextlib import contextmanager

import pytest

from drivers.errors import DeviceTimeout
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.jobs import JobState
from tests.kit.acquisitions import acquire


class Answers(socketserver.StreamRequestHandler):
    """One line for each question; None hangs up."""

    def handle(self):
        for question in self.rfile:
            answer = b"ACME,T,1,1" if b"IDN" in question else self.server.answer()
            if answer is None:
                return
            self.wfile.write(answer + b"\n")


@contextmanager
def thermometer(answer):
    """A thermometer over TCP; the override of a platform that names it."""
    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Answers) as server:
        server.daemon_threads, server.answer = True, answer
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f'thermometer={{backend="scpi",transport="tcp",host="127.0.0.1",tcp_port={server.server_address[1]}}}'
        server.shutdown()


@pytest.mark.long
@pytest.mark.parametrize("nonsense", [b'-113,"Undefined header"', b"-999", b"85.0", b"9.91E37", b"nan", b"", None])
def test_a_series_goes_on_without_a_temperature(engine_with, tmp_path, nonsense):
    """Case 03: nonsense of a thermometer ends no series."""
    wrong = threading.Event()
    with thermometer(lambda: nonsense if wrong.is_set() else b"22.5") as override:
        engine = engine_with(override)
        wrong.set()
        job = acquire(engine, tmp_path / "a.h5", shots=2, window=None)
        assert job.state is JobState.DONE, job.error
        infos = open_recording(tmp_path / "a.h5").frame_info
        assert [(info.verdict, info.temperature_c) for info in infos] == [("good", None), ("good", None)]
        said = [text for text in job.warnings if "temperature" in text]
        assert said[0].startswith("shot 1: the temperature is not known: ")
        assert said[1:] == ["2 shots were made without a known temperature"]
        assert engine.status().temperature_c is None
        row = next(each for each in engine.devices().items if each.device == "thermometer")
        assert row.last_error is not None  # from which the alarm comes


def test_a_thermometer_that_is_not_there_keeps_no_platform_closed(engine_with, tmp_path):
    engine = engine_with('thermometer={backend="scpi",transport="tcp",host="127.0.0.1",tcp_port=9}')
    job = acquire(engine, tmp_path / "a.h5", shots=1, window=None)
    assert job.state is JobState.DONE, job.error
    assert engine.status().error is not None


def test_a_receiver_that_does_not_answer_after_a_shot_makes_it_doubtful_and_keeps_its_samples(
    engine_with, tmp_path, monkeypatch
):
    engine = engine_with()

    def silent():
        raise DeviceTimeout("no answer", where="lna")

    monkeypatch.setattr(engine.platform.lna, "overloaded", silent)
    acquire(engine, tmp_path / "a.h5", shots=1, window=None)
    recording = open_recording(tmp_path / "a.h5")
    assert recording.frame_info[0].verdict == "refused"
    assert "no answer" in recording.frame_info[0].reason
    assert recording.frame_volts(0).any()
