"""Sequences that tune has found, one file per version, used for a resonator as long as its declaration is the same."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

from drivers.errors import ConfigError
from drivers.specimen import Specimen
from drivers.text_files import read_text_file
from platform_daemon.core.hardware.catalogue import Damping, KeptPreset
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.requests import SequencePatch
from platform_daemon.core.state.versioned import Version, VersionedFolder

from .schema import TunedPreset


def declaration_sha256(specimen: Specimen) -> str:
    """Digest of what a resonator file declares, whatever its comments say, and whatever a ramp has found since."""
    return _digest(specimen.model_copy(update={"side_modes": None}))


def _digest(specimen: Specimen) -> str:
    return hashlib.sha256(_text_of(specimen).encode()).hexdigest()


def _text_of(specimen: Specimen) -> str:
    """As presets of earlier versions were marked with, which knew no job of a limit."""
    return specimen.model_dump_json(exclude={"side_modes": {"job"}})


def preset_name(resonator: str) -> str:
    """The name under which a resonator's presets are kept: its own, without version; of a file its stem."""
    return re.sub(r"[^A-Za-z0-9_-]", "_", Path(resonator).name.removesuffix(".toml").partition("@")[0]).lstrip("_-")


@dataclass(frozen=True)
class TunedPresets:
    """`folder` holds NAME@VERSION.json; None: there are none, and none can be kept."""

    folder: Path | None = None

    def keep(self, preset: TunedPreset) -> str | None:
        """Keep a new version; its NAME@VERSION, None: nowhere.  Raises StorageError."""
        if self.folder is None:
            return None
        text = to_json(preset, indent=1).encode()
        return self._files(self.folder).add(preset_name(preset.resonator), ".json", lambda *_: text).path.stem

    def preset_of(self, resonator: str, specimen: Specimen) -> KeptPreset:
        """See TunedSequences."""
        versions = [] if self.folder is None else self._files(self.folder).versions(preset_name(resonator))
        if not versions:
            return KeptPreset()
        newest = versions[-1]
        preset = self._read(newest)
        # Earlier versions took what a ramp has found for a part of the declaration.
        if preset.declaration_sha256 not in (declaration_sha256(specimen), _digest(specimen)):
            why = f"preset {newest.path.stem} was tuned for another declaration of {resonator}: not used; tune again"
            return KeptPreset(stale=why)
        return KeptPreset(
            keys=preset.found.sequence or SequencePatch(),
            label=newest.path.stem,
            job=preset.procedure,
            date=preset.date,
            damping=_damping(preset),
        )

    @staticmethod
    def _files(folder: Path) -> VersionedFolder:
        return VersionedFolder(folder, r"\.json")

    @staticmethod
    def _read(version: Version) -> TunedPreset:
        try:
            return TunedPreset.model_validate_json(read_text_file(version.path))
        except (OSError, ValueError) as error:
            why = str(error).splitlines()[0]
            remedy = "remove the file, or tune again"
            raise ConfigError("this preset cannot be read", where=str(version.path), why=why, remedy=remedy) from None


def _damping(preset: TunedPreset) -> Damping | None:
    """What the fits of the tune have found of it; a thread has no dry friction."""
    viscous, dry = preset.found.lambda_per_s, preset.found.tf_over_i_rad_per_s2
    return None if viscous is None else Damping(max(0.0, viscous.value), 0.0 if dry is None else max(0.0, dry.value))
