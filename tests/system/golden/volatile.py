"""What differs from run to run, replaced by placeholders that keep its type."""

from __future__ import annotations

import hashlib
import re
from datetime import UTC, datetime, timedelta
from pathlib import Path

NUMBER = r"-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?"
_TIMINGS = "seconds|time_left_s|modified_ns|warm_up_s|fit_ms|noise_ms|demodulation_ms|fit_over_demodulation"
_PORTS = "port|command_port|data_port|control_port"
# The lengths of a recording's windows are `seconds` beside their `samples`: they are no timings and stay.
_TIMING = re.compile(rf'("samples":\s*\d+,\s*)?("(?:{_TIMINGS})":\s*)({NUMBER})')
_PORT = re.compile(rf'("(?:{_PORTS})":\s*)(\d+)')
_TIME = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(?:\.\d+)?")
_DATE = re.compile(r"(?<=_)20\d{6}(?=\.|\"|'|\b)")
_JOB = re.compile(r"(?<![a-z])([a-z]+)-\d{8}T\d{6}-[0-9a-f]{6}")
_FIT_TIMES = re.compile(r'("computing_s":\s*\{)([^}]*)\}')
_DIGEST = re.compile(r'("sha256":\s*")([0-9a-f]{64})"')
_PHRASES = (
    (re.compile(r"found in \d+\.\d+ s"), "found in <float> s"),
    (re.compile(r"\(\d+ s left\)"), "(<int> s left)"),
    (re.compile(r"measuring it took [0-9.]+ s"), "measuring it took <float> s"),
    (re.compile(r"127\.0\.0\.1:\d{4,5}"), "127.0.0.1:<port>"),
    (re.compile(r"/[\w/.-]*/lab-emulator-\w+/"), "<temporary>/"),
    (re.compile(r"(declared model [^;\n]+); [0-9.]+ s"), r"\1; <float> s"),
    (re.compile(r"(│ +(?:N50|D30) │.*│ +)\d+\.\d{3} │$", re.MULTILINE), r"\1<float> │"),  # time of a fit
    (re.compile(r"series_id='[0-9a-f]{32}'"), "series_id='<id>'"),
    # How far a shot was that was cut off.
    (re.compile(r'("phase":\s*"failed",\s*"fraction":\s*)0\.0*[1-9]\d*'), r'\1"<float>"'),
    (re.compile(r"the log has it under [0-9a-f]{8}"), "the log has it under <reference>"),
)


class Placeholders:
    """Those of one run: the same job is the same placeholder wherever it is named.

    folders: absolute path -> name; version: of the program.  Digests of `inputs` stay; a recording that was measured
    holds the time of day and has another digest every time.
    """

    def __init__(self, folders: dict[Path, str], version: str) -> None:
        self._inputs: set[str] = set()
        self._folders = {str(path): name for path, name in folders.items()}
        self._version = version
        self._jobs: dict[str, str] = {}
        self._counts: dict[str, int] = {}

    def input(self, path: Path) -> None:
        """A file that is the same in every run."""
        self._inputs.add(hashlib.sha256(path.read_bytes()).hexdigest())

    def clean(self, text: str) -> str:
        """The text with every volatile value replaced; whitespace and the form of all other values stay."""
        for path in sorted(self._folders, key=len, reverse=True):
            text = text.replace(path, self._folders[path])
        text = _JOB.sub(lambda m: self._job(m[0], m[1]), text)
        text = _TIME.sub(lambda m: re.sub(r"\d", "#", m[0]) if _now(m[0]) else m[0], text)
        text = _DATE.sub(lambda m: "########" if _now(f"{m[0][:4]}-{m[0][4:6]}-{m[0][6:]}") else m[0], text)
        text = _TIMING.sub(_untimed, text)
        text = _FIT_TIMES.sub(_untimed_fits, text)
        text = _PORT.sub(r'\1"<int>"', text)
        text = text.replace(f'"{self._version}"', '"<version>"').replace(f"'{self._version}'", "'<version>'")
        text = _DIGEST.sub(lambda m: m[0] if m[2] in self._inputs else f'{m[1]}<digest>"', text)
        for pattern, placeholder in _PHRASES:
            text = pattern.sub(placeholder, text)
        return text

    def _job(self, identifier: str, kind: str) -> str:
        if identifier not in self._jobs:
            self._counts[kind] = self._counts.get(kind, 0) + 1
            self._jobs[identifier] = f"{kind}-<{self._counts[kind]}>"
        return self._jobs[identifier]


def _untimed(found: re.Match[str]) -> str:
    samples, key, number = found.groups(default="")
    return found[0] if samples and key.startswith('"seconds"') else f'{samples}{key}"{_kind(number)}"'


def _untimed_fits(found: re.Match[str]) -> str:
    """Statistics of computing times, but for how many there are."""
    times = re.sub(rf'("(?!shots)\w+":\s*)({NUMBER})', lambda m: f'{m[1]}"{_kind(m[2])}"', found[2])
    return f"{found[1]}{times}}}"


def _kind(number: str) -> str:
    return "<int>" if number.lstrip("-").isdigit() else "<float>"


def _now(text: str) -> bool:
    """Is it a time of this run?  Times that a file or an option names stay as they are."""
    try:
        when = datetime.fromisoformat(text)
    except ValueError:
        return False
    return abs(when.replace(tzinfo=UTC) - datetime.now(UTC)) < timedelta(days=2)
