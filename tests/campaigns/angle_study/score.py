"""What the diagnosis says against what was drawn."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.campaigns.angle_study.cases import ALSO_CALLED, CASES
from tests.campaigns.angle_study.command import TOO_LONG, TRACEBACK, Command
from tests.campaigns.angle_study.record import Record, least_error, speaks_against, written

SPLIT = 0.7  # of a record: what is after is held out
RATIO = 1.3  # of the held-out errors, ours to that of the true model
VISIBLE = 15.0
_GAP, _CLIPPED = "clock_gap", "saturat"
_LOSSES = ("lambda_per_s", "coulomb_friction", "hertz_friction", "quadratic_drag")
_SURE = 2.0  # standard deviations


@dataclass(frozen=True)
class Score:
    """One record of the study, as its journal has it.

    result: exact, inside (the set of look-alikes), extra (besides, a name that is not there), missed, wrong (such a
        name without the right ones), refused, traceback, slow.
    against: visibility of what is wrong with the names that were said, where scipy can fit them.
    gaps: (sample, samples lost, visibility in the whole record, near it). ratio: of the held-out errors.
    """

    seed: int
    index: int
    case: str
    sigma: float
    seen_sigma: float
    what: str
    result: str
    verdict: str
    names: tuple[str, ...]
    alike: tuple[str, ...]
    gaps: tuple[tuple[float, ...], ...]
    gaps_told: tuple[tuple[float, float], ...]
    false_gaps: int
    missed_gaps: int
    clipping: bool
    negative: tuple[str, ...]
    error_after: float | None
    error_true: float
    seconds: float
    memory_mb: float
    said: str
    against: float | None

    @property
    def right(self) -> bool:
        """Named rightly, or inside the declared set, and no gap that is not there."""
        return self.result in ("exact", "inside") and not self.false_gaps

    @property
    def ratio(self) -> float | None:
        """Of the held-out errors."""
        return None if self.error_after is None else self.error_after / self.error_true

    @property
    def flaws(self) -> list[str]:
        """What is wrong besides names."""
        ratio = self.ratio
        found = [f"{self.false_gaps} false gaps"] if self.false_gaps else []
        found += [f"{self.missed_gaps} missed gaps"] if self.missed_gaps else []
        found += ["false clipping"] if self.clipping else []
        found += [f"held-out error {ratio:.3g} times that of the true model"] if ratio and ratio > RATIO else []
        return found + [f"negative {name}" for name in self.negative]


def scored(record: Record, command: Command, folder: Path) -> Score:
    """Diagnose a record and compare."""
    path, told = written(record, folder / "record.h5"), folder / "record.json"
    told.unlink(missing_ok=True)
    answer = command("diagnose", path, "--json", told)
    report = json.loads(told.read_text(encoding="utf-8")) if told.exists() else {}
    path.unlink()
    effects = report.get("effects", [])
    names = tuple(dict.fromkeys(e["id"] for e in effects))
    sets = [{e["id"], *e["indistinguishable_from"]} for e in effects]
    gaps = [(*gap, *seen) for gap, seen in zip(record.gaps, record.gap_sigmas, strict=True)]
    gaps_told = _gaps_told(effects)
    matched = [_matches(gap, gaps_told, record) for gap in gaps]
    text = answer.errors + " ".join(d["id"] for d in report.get("integrity", []))
    draw = record.draw
    result = _result(record, str(report.get("verdict", "")), sets, names)
    if not report:
        result = {TRACEBACK: "traceback", TOO_LONG: "slow"}.get(answer.code, "refused" if answer.code else "traceback")
    if result in ("exact", "inside") and not all(m or gap[2] < VISIBLE for m, gap in zip(matched, gaps, strict=True)):
        result = "missed"
    return Score(
        seed=draw.seed, index=draw.index, case=draw.case.name, sigma=record.sigma, seen_sigma=record.seen_sigma,
        what=_what(record), result=result, verdict=str(report.get("verdict", "")), names=names,
        alike=tuple(i for e in effects for i in e["indistinguishable_from"]), gaps=tuple(gaps), gaps_told=gaps_told,
        false_gaps=len(gaps_told) - sum(matched),
        missed_gaps=sum(not m for m, gap in zip(matched, gaps, strict=True) if gap[2] >= VISIBLE) if report else 0,
        clipping=_CLIPPED in text.lower(), negative=_negative(report),
        error_after=report.get("held_out", {}).get("nrmse_after"), error_true=least_error(record, SPLIT),
        seconds=answer.seconds, memory_mb=answer.memory_mb, said=_last(answer.errors.replace(f"{folder}/", "")),
        against=speaks_against(record, names) if report and result not in ("exact", "inside") else None,
    )  # fmt: skip


def _last(errors: str) -> str:
    lines = [line for line in errors.splitlines() if line.strip()]
    return lines[-1].strip()[:300] if lines else ""


def _result(record: Record, verdict: str, sets: list[set[str]], names: tuple[str, ...]) -> str:
    """By names alone; a gap's place and size are judged by themselves."""
    case = record.draw.case
    true = [ALSO_CALLED.get(name, {name}) for name in _visible(record)]
    if case.outside:
        if any("zero" in n or "offset" in n for n in names) and case.name == "zero-drift":
            return "exact"
        return "wrong" if names else "missed" if verdict == "nothing_missing" else "exact"
    if not case.effects:
        return "wrong" if names else "exact" if verdict == "nothing_missing" else "missed"
    known = set().union(*true, *({n} for n in case.optional), *({n} for n in case.effects))
    all_said = all(any(found & t for found in sets) for t in true)
    if any(not found & known for found in sets):
        return "extra" if all_said else "wrong"
    if not all_said:
        return "missed"
    return "exact" if all(n in known for n in names) and all(set(names) & t for t in true) else "inside"


def _visible(record: Record) -> list[str]:
    """Effects that are to be named: a gap only if it can be seen."""
    unseen = record.gaps and all(whole < VISIBLE for whole, _ in record.gap_sigmas)
    return [name for name in record.draw.case.effects if not (unseen and name == _GAP)]


def _gaps_told(effects: list[Mapping[str, Any]]) -> tuple[tuple[float, float], ...]:
    """(sample, samples lost)."""
    return tuple((float(e["detail"]["sample"]), float(e["strength"]["value"])) for e in effects if e["id"] == _GAP)


def _matches(gap: tuple[float, ...], told: tuple[tuple[float, float], ...], record: Record) -> bool:
    """Told within half a period and by its size, to the sample."""
    near = 0.5 * record.draw.rate_hz / record.motion["f_hz"]
    return any(abs(at - gap[0]) <= near and abs(lost - gap[1]) < 0.5 for at, lost in told)


def _negative(report: Mapping[str, Any]) -> tuple[str, ...]:
    """Losses that give energy, surely."""
    found = {n: m for n, m in report.get("parameters_after", {}).items() if n in _LOSSES}
    found |= {e["id"]: e["strength"] for e in report.get("effects", []) if e["id"] in _LOSSES}
    return tuple(n for n, m in found.items() if m["value"] is not None and m["value"] < -_SURE * (m["std"] or 0.0))


def _what(record: Record) -> str:
    d, m = record.draw, record.motion
    parts = [f"{d.duration_s:.0f} s at {d.rate_hz:g} Hz, f0 {m['f_hz']:.2f} Hz, {d.amplitude:.2f} rad, {d.bits} bit"]
    parts += [f"noise {d.white_rad / d.quantum_rad:.2f} counts"]
    parts += [f"{name} {m[name]:.3g}" for name in (*d.case.strengths, *d.case.shape)]
    parts += [f"rests at {record.rests_s:.1f} s"] if record.rests_s < d.duration_s else []
    return ", ".join(parts)


def case_names() -> list[str]:
    """Of all rows."""
    return [case.name for case in CASES]
