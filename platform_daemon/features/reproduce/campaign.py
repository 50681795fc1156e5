"""A campaign: what is measured of each resonator, the folder that holds it, and what of it is there."""

from __future__ import annotations

from pathlib import Path

from pydantic import ValidationError

from drivers.errors import InputError
from drivers.validation import validated
from platform_daemon import __version__
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.state.durable import write_file
from platform_daemon.features.characterise.schema import CharacteriseOutcome, CharacteriseRequest
from platform_daemon.features.procedures.bench import ReportFiles
from platform_daemon.features.procedures.schema import ProcedureLog

from .schema import Campaign

BLANK_SHOTS = 4
"""Before the shots of each, as characterise has it."""
_FITS_PER_LEVEL = 30  # of the noise sweep: of fewer shots several draws of noise
# tab:measurement_parameter; the jewel waits a second longer, for else shots of little friction are not at rest.  How
# long the switch takes is not printed: all four means of psi_start in tab:model_params_fit_result agree with this.
_SEQUENCES = {
    "thread": {"f_tx_hz": 212.0, "tx_periods": 10, "switch_s": 0.01105, "rx_s": 15.0, "pause_s": 0.0},
    "jewel": {"f_tx_hz": 212.0, "tx_periods": 10, "switch_s": 0.01105, "rx_s": 2.0, "pause_s": 1.0},
}
_HIGHEST_T = {"thread": 330e-6, "jewel": 740e-6}  # of a ramp: 1.2 of the paper's B_max (ssec:measurement_sequence)
# Of --quick: from 80 % of the paper's field on, as half of it takes twice the shots; steps of a tenth of that field.
_QUICK_FIELDS = {"thread": {"start_t": 170e-6, "step_t": 20e-6}, "jewel": {"start_t": 390e-6, "step_t": 50e-6}}
# Of on-line fits, by which tune and ramp go: a thread whose f_nat settles after the burst (thread_published) is refused
# over D30 at small swings; a jewel's two losses cannot be told apart over N50.
_WINDOWS = {"thread": "n50", "jewel": "d30"}


def check_folder(out: Path, campaign: Campaign, *, resume: bool) -> None:
    """Raises InputError for a folder that holds something else, or a campaign of another version or request."""
    file = out / "campaign.json"
    if not resume:
        if out.is_file():
            raise InputError("is a file", where=str(out), remedy="name a folder")
        if out.is_dir() and any(out.iterdir()):
            raise InputError("the folder is not empty", where=str(out), remedy="name another one, or give --resume")
        return
    try:
        before = Campaign.model_validate_json(file.read_bytes())
    except (OSError, ValidationError):
        remedy = "name the folder of one, or leave --resume out"
        raise InputError("there is no campaign to continue", where=str(file), remedy=remedy) from None
    if before != campaign:
        named = [name for name in type(campaign).model_fields if getattr(before, name) != getattr(campaign, name)]
        why = "; ".join(f"{n}: {getattr(before, n)} there, {getattr(campaign, n)} now" for n in named)
        remedy = "continue it as it was begun, or begin a new folder"
        raise InputError("the campaign was begun differently", where=str(file), why=why, remedy=remedy)


def begin(out: Path, campaign: Campaign) -> None:
    """Note what a folder is measured with.  Raises StorageError."""
    out.mkdir(parents=True, exist_ok=True)
    write_file(out / "campaign.json", to_json(campaign, indent=1).encode())


def is_measured(out: Path, variant: str, resonator: str) -> bool:
    """It is there whole.  Raises InputError for another resonator's, and one of another version."""
    return (out / f"{variant}.h5").is_file() and outcome_in(out, variant, of=resonator) is not None


def held_in_n50(out: Path, variant: str) -> dict[str, float]:
    """What N50 holds: for the jewel the thread's lambda of D30 (ssec:analysis_of_measurement_data), if it is known."""
    thread = outcome_in(out, "thread") if variant == "jewel" else None
    found = None if thread is None else thread.report.d30.parameters.get("lambda_per_s")
    return {} if found is None else {"lambda_per_s": found.mean}


def characterise_request(
    campaign: Campaign, variant: str, resonator: str, held: dict[str, float]
) -> CharacteriseRequest:
    """Of one resonator; held: in its N50 fits.  Raises InputError."""
    fields = {"max_t": _HIGHEST_T[variant]} | (_QUICK_FIELDS[variant] if campaign.quick else {})
    keys = {
        "kind": "characterise",
        "acquisition": {
            "resonator": resonator,
            "shots": campaign.shots,
            "blank_shots": BLANK_SHOTS,
            "window": _WINDOWS[variant],
            "sequence": _SEQUENCES[variant],
        },
        "held_in_n50": held,
        "tune": campaign.tune,
        "ramp": fields if campaign.finds_field else None,
    }
    return validated(CharacteriseRequest, keys, "reproduce")


def outcome_in(folder: Path, variant: str, *, of: str | None = None) -> CharacteriseOutcome | None:
    """What a resonator's procedure has found; None: it was not made, or did not come to its end.

    of: the resonator that is meant.  Raises InputError for a log that another version wrote, and of another resonator.
    """

    file = folder / f"{variant}.h5.log.json"
    if not file.is_file():
        return None
    remedy = "measure again into another folder"
    try:
        log = ProcedureLog.model_validate_json(file.read_bytes())
    except ValidationError:
        raise InputError("is no log of a procedure of this version", where=str(file), remedy=remedy) from None
    if log.software_version != __version__:
        why = f"{log.software_version} wrote it, this is {__version__}"
        raise InputError("was written by another version", where=str(file), why=why, remedy=remedy)
    there = log.request.acquisition.resonator
    if of is not None and there != of:
        remedy = f"give --{variant} {there}, or begin a new folder"
        raise InputError(f"is of {there}, not of {of}", where=str(file), remedy=remedy)
    return log.result.outcome if isinstance(log.result.outcome, CharacteriseOutcome) else None


def draws_of(shots: int) -> int:
    """Draws of noise for each shot and level."""
    return max(1, round(_FITS_PER_LEVEL / shots))


def report_files(recording: Path) -> ReportFiles:
    """Report and page of a resonator, beside its recording."""
    return ReportFiles(report=recording.with_suffix(".json"), html=recording.with_suffix(".html"))
