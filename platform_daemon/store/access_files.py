"""Who may, and who did: two files of a data folder, for processes that need no other of it."""

from __future__ import annotations

from pathlib import Path

from .audit import AuditLog
from .tokens import TokenFile

TOKENS, AUDIT = "tokens.json", "audit.jsonl"


def tokens_in(folder: Path) -> TokenFile:
    """The tokens of a data folder, which a daemon may have open."""
    return TokenFile(folder / TOKENS)


def audit_log_in(folder: Path) -> AuditLog:
    """The audit log of a data folder, which a daemon may have open."""
    return AuditLog(folder / AUDIT)
