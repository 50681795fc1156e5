"""Sequences that tune has found, one file per version, used for a resonator as long as its declaration is the same."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from drivers.errors import ConfigError
from drivers.specimen import Specimen
from platform_daemon.schemas import SequencePatch, TunedPreset, to_json
from platform_daemon.store import Version, VersionedFolder


def declaration_sha256(specimen: Specimen) -> str:
    """Digest of what a resonator file declares, whatever its comments say."""
    return hashlib.sha256(specimen.model_dump_json().encode()).hexdigest()


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

    def keys_for(self, resonator: str, specimen: Specimen) -> tuple[SequencePatch, str | None]:
        """The keys of the newest preset, none without one; and a warning if it is for another declaration.

        Raises ConfigError for a file that is damaged.
        """
        versions = [] if self.folder is None else self._files(self.folder).versions(preset_name(resonator))
        if not versions:
            return SequencePatch(), None
        newest = versions[-1]
        preset = self._read(newest)
        if preset.declaration_sha256 != declaration_sha256(specimen):
            why = f"preset {newest.path.stem} was tuned for another declaration of {resonator}: not used; tune again"
            return SequencePatch(), why
        return preset.found.sequence or SequencePatch(), None

    @staticmethod
    def _files(folder: Path) -> VersionedFolder:
        return VersionedFolder(folder, r"\.json")

    @staticmethod
    def _read(version: Version) -> TunedPreset:
        try:
            return TunedPreset.model_validate_json(version.path.read_bytes())
        except (OSError, ValidationError) as error:
            why = str(error).splitlines()[0]
            remedy = "remove the file, or tune again"
            raise ConfigError("this preset cannot be read", where=str(version.path), why=why, remedy=remedy) from None
