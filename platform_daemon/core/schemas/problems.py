"""Errors as RFC 9457 problem details."""

from __future__ import annotations

from pydantic import ConfigDict

from .base import Absent, Schema, example


class Problem(Schema):
    """What went wrong, where and why, and what to do about it (RFC 9457, `application/problem+json`)."""

    model_config = ConfigDict(json_schema_extra=example("problem"))

    type: str
    """Path of the page that explains this kind of problem; "about:blank": the status says it all."""
    title: str
    """Kind of the problem in words."""
    status: int
    """HTTP status."""
    detail: Absent[str] = None
    """Where, what, why and the remedy, in one line."""
    instance: Absent[str] = None
    """Path of the request or of the job."""
    where: Absent[str] = None
    """File, key, device or field of the request."""
    remedy: Absent[str] = None
    """What to do."""


class ProblemKind(Schema):
    """What a kind of problem means."""

    model_config = ConfigDict(json_schema_extra=example("problem_kind"))

    type: str
    """Path of this page, as in `type` of a problem."""
    title: str
    """Kind of the problem in words."""
    meaning: str
    """When it happens."""


class UnreadableFile(Schema):
    """A file that looks like what is listed but cannot be used."""

    id: str
    """What its id or name would be."""
    path: str
    """Name of the file."""
    error: Problem
    """Why."""


class ErrorRecord(Schema):
    """An error as the record of a job keeps it."""

    title: str
    """Kind of the error."""
    what: str
    """What happened."""
    where: str
    """File, key, device or field of the request; empty: not said."""
    why: str
    """The cause; empty: not known."""
    remedy: str
    """What to do; empty: nothing."""
