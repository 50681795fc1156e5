"""`platform-daemon retention`: list old recordings that may be removed; archive or delete them on request."""

from __future__ import annotations

import itertools
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from drivers.errors import InputError
from platform_daemon.features.trends.command import FOLDER, FolderOption, updated

MADE_FROM = ("models", "presets", "resonators")
"""Folders next to the folder of the recordings, whose files name the recordings that they were made from."""
_MOST_DAYS = 36_525.0


def retention(
    older_than_days: Annotated[float, typer.Option(min=1, help="Only those that began before.")],
    keep_newest: Annotated[int, typer.Option(min=0, help="So many of every specimen stay, whatever their age.")] = 10,
    keep_tag: Annotated[list[str] | None, typer.Option(help="Those with this tag stay; without it: keep.")] = None,
    archive: Annotated[Path | None, typer.Option(help="Move them into this folder.")] = None,
    delete_them: Annotated[bool, typer.Option("--delete", help="Delete them for good.")] = False,
    recordings: FolderOption = FOLDER,
) -> None:
    """List the recordings that may be removed; --archive or --delete removes them."""
    from platform_daemon.core.recordings.index import recording_files
    from platform_daemon.core.recordings.retention import RetentionRules, delete, move_away, named_in, old_recordings

    if not older_than_days <= _MOST_DAYS:  # nor is it no number
        remedy = "name an age of days, as 365"
        raise InputError(f"{older_than_days:g} is no age", where="--older-than-days", remedy=remedy)
    if archive is not None and delete_them:
        raise InputError("--archive and --delete exclude each other", where="--delete", remedy="choose one of them")
    if archive is not None and (not archive.is_dir() or archive.resolve() == recordings.resolve()):
        remedy = "make the folder first; it is another one than that of the recordings"
        raise InputError("is no folder to move them to", where=str(archive), remedy=remedy)
    if not all(tag.removeprefix("#").strip() for tag in keep_tag or ["keep"]):
        remedy = "name a tag, or leave the option out: those with the tag keep stay then"
        raise InputError("names no tag", where="--keep-tag", remedy=remedy)
    updated(recordings, rebuild=False)
    tags = frozenset(tag.removeprefix("#").casefold() for tag in keep_tag or ["keep"])
    everyone = {path.stem for path in recording_files(recordings)}
    needed = frozenset(itertools.chain(*(named_in(recordings.parent / each, everyone) for each in MADE_FROM)))
    rules = RetentionRules(older_than_days, keep_newest, tags, needed)
    old = old_recordings(recordings, rules, datetime.now(UTC))
    for each in old:
        print(f"{each.begun[:19]}  {each.size / 1e6:9.1f} MB  {each.specimen}  {each.file}")
    kept = f"; {len(needed)} stay because a model, a preset or a resonator was made from them" if needed else ""
    total = f"{len(old)} recordings, {sum(each.size for each in old) / 1e9:.3f} GB"
    if archive is not None:
        move_away(recordings, old, archive)
        print(f"{total}, moved to {archive}{kept}")
    elif delete_them:
        delete(recordings, old)
        print(f"{total}, deleted{kept}")
    else:
        print(f"{total} would go; nothing was touched: --archive FOLDER moves them, --delete deletes them{kept}")
