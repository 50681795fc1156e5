"""What is done to the emulated lab, and what must come of it: written down by device, phase and kind before any run.

A cell of the catalogue is one kind of fault of one device in one phase of the daemon's work.  Its expectation is an
outcome and words that the error or the reason of the refused shot must contain.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum

CARDS = ("io_card_0", "io_card_1")
AMPLIFIER, SWITCH, LNA = "amplifier", "switch", "lna"
LOST = ("timeout", "garbage", "half_reply", "disconnect")
DEAD = ("one_way_link", "deaf_link")
SLOW = "slow_link"


class Outcome(StrEnum):
    """How a fault may end."""

    NO_START = "the daemon does not start, nothing is energised"
    BEFORE_POWER = "the next shot is refused before it is energised, the series ends"
    SELF_TEST = "the self-test refuses the series, there is no file"
    SHOT_REFUSED = "the shot is refused, the series goes on"
    STOPPED = "the series ends, the shots before are kept"
    VALID = "all shots are good and equal to the simulation"


@dataclass(frozen=True)
class Site:
    """Where a fault of a wire strikes: which answers count (see `sim_backend.emulators.wire_faults.WireFault`).

    commands: one of these texts; chunk: of the data stream, 0: the first, -1: the last; early: before there is an
    engine.
    """

    phase: str
    commands: tuple[str, ...] = ()
    when: str = "any"
    chunks: tuple[int, ...] = ()
    early: bool = False


@dataclass(frozen=True)
class Expected:
    """Outcome, and a pattern of which the error or reason must contain a match; before_more: the outcome if another
    shot was to follow, None: the same."""

    outcome: Outcome
    words: str = ""
    before_more: Outcome | None = None

    def of_shot(self, *, last: bool) -> Outcome:
        """The outcome if the fault strikes in the last shot or in one before it."""
        return self.outcome if last or self.before_more is None else self.before_more


@dataclass(frozen=True)
class Cell:
    """One kind of fault of one device in one phase; `world`: it is not on the wire but in the device itself."""

    device: str
    kind: str
    site: Site
    expected: Expected
    world: bool = False
    part: str = field(default="")

    @property
    def name(self) -> str:
        """For tables and logs."""
        return f"{self.device} {self.site.phase}{' ' + self.part if self.part else ''}: {self.kind}"


SILENT = r"no answer|not answer|answered|outputs cannot be confirmed|could not be confirmed|takes no data|not 11"
GARBLED = rf"{SILENT}|makes no sense|garbage|no end|no USBTMC|refused|gone|another device|not 2048"
CUT = r"gone|broke|broken|closed|no connection|could not be confirmed|garbage|no end|reset|not 11"
WORDS = {
    "timeout": rf"{SILENT}|makes no sense",
    "garbage": GARBLED,
    "half_reply": GARBLED,
    "disconnect": rf"{CUT}|{SILENT}",
    "one_way_link": SILENT,
    "deaf_link": SILENT,
    "slow_link": "",
}

CARD_SITES = (
    Site("connect", ("*IDN?", "COMPONENT1:AMPLITUDE 0"), early=True),
    Site("identify", ("VERSION:IMAGE", "CALIB:ADC:CHANNEL0:SCALE", "CALIB:FLAGS", "ADC:DECIMATION?"), early=True),
    Site("arm", ("MODE ACQUISITION",), when="idle"),  # the second card has nothing to play in these shots
    Site("TX", ("RP:TRIGGER?", "PIPELINED")),
    Site("readout", ("RP:STATUS?", "INSTANTRESET:TRIGGERED?", "TRIGGER:ALIVE ON"), when="shot"),
    Site("trigger off", ("MODE CONFIGURATION",), when="after_shot"),
    Site("off", ("CHANNEL0:OFFSET?", "COMPONENT1:AMPLITUDE?"), when="after_shot"),
    Site("idle", ("RP:MODE?",), when="idle"),
)
_NEXT_SHOT = ("RP:STATUS?", "SEQ:SET")  # asked of the card that has something to play, before anything is energised
MASTER_SITES = (
    *(replace(site, commands=(*_NEXT_SHOT, *site.commands)) if site.phase == "arm" else site for site in CARD_SITES),
    Site("RX", ("RP:ADC:WP?",)),
)
STREAM_SITES = (
    Site("TX", chunks=(0, 1)),
    Site("switch-over", chunks=(2,)),
    Site("RX", chunks=(3, 4, 6, 9)),
    Site("readout", chunks=(-1,)),
    Site("self-test", chunks=(0, 1, 2)),
)
SWITCH_SITES = (
    Site("status in RX", ("*IDN?",), when="shot"),
    Site("connect", ("*IDN?",), early=True),
    Site("identify", ("TIM?", "FOLLOW", "POS?"), early=True),
    Site("arm", ("POS?",), when="idle"),
    Site("RX", ("POS?",), when="shot"),
    Site("readout", ("MOVE?",), when="after_shot"),
    Site("proof of off", ("POS?",), when="after_shot"),
    Site("idle", ("*IDN?", "POS?"), when="idle"),
    Site("self-test", ("POS?",), when="shot"),
)
LNA_SITES = (
    Site("status in RX", ("*IDN?", "GAIN?"), when="shot"),
    Site("connect", ("*IDN?",), early=True),
    Site("identify", ("GAINS?", "GAIN 40", "GAIN?"), early=True),
    Site("arm", ("OVL:CLR",), when="idle"),
    Site("readout", ("OVL?",), when="after_shot"),
    Site("idle", ("*IDN?", "GAIN?", "OVL?"), when="idle"),
    Site("self-test", ("OVL?",), when="after_shot"),
)
AMPLIFIER_SITES = (
    Site("status in RX", ("*IDN?",), when="shot"),
    Site("connect", ("*IDN?",), early=True),
    Site("identify", ("OUTP?",), early=True),
    Site("arm", ("SYST:ERR?", "STAT:FAULT?", "OUTP?"), when="idle"),
    Site("switch-over", ("STAT:CLIP?", "OUTP:MUTE?", "OUTP?"), when="shot"),
    Site("readout", ("OUTP?",), when="after_shot"),
    Site("idle", ("*IDN?", "SYST:TEMP?", "STAT:CLIP?"), when="idle"),
    Site("self-test", ("STAT:CLIP?", "OUTP?"), when="shot"),
)


def cells() -> list[Cell]:
    """The whole catalogue."""
    return [*_card_cells(), *_stream_cells(), *_controller_cells(), *_reconnect_cells(), *_world_cells()]


def _wire(
    device: str, kind: str, site: Site, outcome: Outcome, part: str = "", before_more: Outcome | None = None
) -> Cell:
    words = "" if outcome is Outcome.VALID else WORDS[kind]
    return Cell(device, kind, site, Expected(outcome, words, before_more), part=part)


def _card_cells() -> list[Cell]:
    """The command socket.  What goes wrong while connecting or while proving outputs off is mended by a new connection,
    and so is a card that hangs up while it is asked who it is; a link that stays dead is not."""
    outcomes = {
        "connect": (Outcome.VALID, Outcome.NO_START),
        "identify": (Outcome.NO_START, Outcome.NO_START),
        "arm": (Outcome.BEFORE_POWER, Outcome.BEFORE_POWER),
        "TX": (Outcome.STOPPED, Outcome.STOPPED),
        "readout": (Outcome.STOPPED, Outcome.STOPPED),
        "off": (Outcome.VALID, Outcome.STOPPED),
        "idle": (Outcome.VALID, Outcome.BEFORE_POWER),
    }
    found = []
    for device in CARDS:
        sites = MASTER_SITES if device == CARDS[0] else CARD_SITES
        for site in sites:
            once, for_good = outcomes.get(site.phase, (Outcome.STOPPED, Outcome.STOPPED))
            hung_up = Outcome.VALID if site.phase == "identify" else once
            lost = {**dict.fromkeys(LOST, once), "disconnect": hung_up, **dict.fromkeys(DEAD, for_good)}
            found += [_wire(device, kind, site, outcome, "commands") for kind, outcome in lost.items()]
            found.append(_wire(device, SLOW, site, Outcome.VALID, "commands"))
    return found


def _stream_cells() -> list[Cell]:
    """The data socket.  Missing bytes shift all that follow, so that a record makes no sense; at the end nothing
    follows.  TCP has a checksum for the samples, our protocol has none: garbage strikes records only."""
    found = []
    for device in CARDS:
        for site in STREAM_SITES:
            bytes_missing = Outcome.STOPPED if site.phase == "readout" else Outcome.SHOT_REFUSED
            outcomes = {
                "timeout": (bytes_missing, "no samples arrive|makes no sense|trigger fell"),
                "half_reply": (bytes_missing, "no samples arrive|makes no sense|trigger fell"),
                "garbage": (Outcome.SHOT_REFUSED, "makes no sense|trigger fell"),
                "disconnect": (Outcome.STOPPED, WORDS["disconnect"]),
                "one_way_link": (Outcome.STOPPED, "no samples arrive"),
                SLOW: (Outcome.VALID, ""),
            }
            for kind, (outcome, words) in outcomes.items():
                if site.phase == "self-test" and outcome is Outcome.SHOT_REFUSED:
                    outcome, words = Outcome.VALID, ""  # the self-test is tried twice
                elif site.phase == "self-test" and outcome is Outcome.STOPPED:
                    outcome = Outcome.SELF_TEST
                found.append(Cell(device, kind, site, Expected(outcome, words), part="data"))
    return found


def _controller_cells() -> list[Cell]:
    """Serial switch, LNA, amplifier over USB: an exchange that failed is opened again by the next one.

    Switch and LNA are queried after the samples are there: one that does not answer makes the shot doubtful, so that it
    is refused, and a tone of the self-test, so that it is tried twice.  The next shot of an LNA that stays dead is not
    begun.  The amplifier's temperature is not asked between TX and RX.
    """
    once = {
        "connect": Outcome.NO_START,
        "identify": Outcome.NO_START,
        "arm": Outcome.BEFORE_POWER,
        "idle": Outcome.VALID,
        "status in RX": Outcome.VALID,
        "self-test": Outcome.SELF_TEST,
    }
    after_samples = {
        (LNA, "status in RX"): (Outcome.VALID, Outcome.SHOT_REFUSED),
        (LNA, "readout"): (Outcome.SHOT_REFUSED, Outcome.SHOT_REFUSED),
        (LNA, "self-test"): (Outcome.VALID, Outcome.SELF_TEST),
        (SWITCH, "readout"): (Outcome.SHOT_REFUSED, Outcome.STOPPED),
    }
    sites = {SWITCH: SWITCH_SITES, LNA: LNA_SITES, AMPLIFIER: AMPLIFIER_SITES}
    found = []
    for device, places in sites.items():
        for site in places:
            lost = once.get(site.phase, Outcome.STOPPED)
            dead = {"idle": Outcome.BEFORE_POWER, "status in RX": Outcome.STOPPED}.get(site.phase, lost)
            lost, dead = after_samples.get((device, site.phase), (lost, dead))
            ends = device == LNA and dead is Outcome.SHOT_REFUSED
            found += [_wire(device, kind, site, lost) for kind in LOST]
            found += [_wire(device, k, site, dead, before_more=Outcome.BEFORE_POWER if ends else None) for k in DEAD]
            found.append(_wire(device, SLOW, site, Outcome.VALID))
    return found


def _reconnect_cells() -> list[Cell]:
    """The connection breaks in the RX window, and a second fault strikes while it is opened again."""
    sites = {
        "handshake": Site("reconnect", ("*IDN?",), when="shot"),  # the trigger is still on
        "registers": Site("reconnect", ("VERSION:SERVER", "CALIB:FLAGS", "ADC:DECIMATION?")),
    }
    kinds = (*LOST, *DEAD, SLOW)
    found = []
    for device in CARDS:
        for part, site in sites.items():
            found += [
                Cell(device, k, site, Expected(Outcome.STOPPED, rf"{WORDS['disconnect']}|{WORDS[k]}"), part=part)
                for k in kinds
            ]
    return found


def _world_cells() -> list[Cell]:
    """Faults of the devices themselves."""
    refused, stopped = Outcome.SHOT_REFUSED, Outcome.STOPPED
    rows = (
        ("io_card", "RX", "overwritten", refused, "overwritten"),
        ("io_card", "RX", "corrupted", refused, "corrupted"),
        ("io_card", "RX", "lost_steps", refused, "lost_steps"),
        ("io_card", "RX", "card_timeout", stopped, "no samples arrive|no answer"),
        ("io_card", "RX", "adc_clip", refused, "end of its range"),
        (AMPLIFIER, "TX", "amplifier_trip", stopped, "tripped"),
        (LNA, "RX", "lna_overload", refused, "overloaded|end of its range"),
        (SWITCH, "switch-over", "relay_bounce", refused, "come to rest|still moved"),
        (SWITCH, "switch-over", "switch_stuck", stopped, "transmit in the RX window"),
        (SWITCH, "readout", "switch_welded", stopped, "on receive, not on transmit"),
    )
    words = "the self-test refuses|{}"
    found = []
    for device, phase, kind, outcome, reason in rows:
        found.append(Cell(device, kind, Site(phase), Expected(outcome, reason), world=True))
        tested = Expected(Outcome.SELF_TEST, words.format(reason))
        if outcome is refused:  # the self-test is tried twice
            tested = Expected(Outcome.VALID)
        found.append(Cell(device, kind, Site("self-test"), tested, world=True))
    return found
