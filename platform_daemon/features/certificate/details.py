"""Who issues a certificate to whom: what no recording knows."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field


def _words(text: str) -> str:
    """Raises ValueError for what cannot be printed, and for nothing but blanks."""
    if not text.strip() or not text.isprintable():
        raise ValueError("must be words in one line that can be printed")
    return text.strip()


Text = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(_words)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Contact(_Section):
    """A laboratory or a customer."""

    name: Text = Field(description="Its name.")
    city: Text = Field(description="Where it is.")
    country: Annotated[str, Field(pattern="^[A-Z]{2}$")] = Field(description="Country, two letters (ISO 3166-1).")


class CertificateDetails(_Section):
    """What `--details FILE` holds."""

    number: Text = Field(description="Number of the certificate, unique to the laboratory.")
    person: Text = Field(description="Who is responsible, and signs.")
    laboratory: Contact
    customer: Contact
    accepted_misfit: Text | None = Field(
        default=None,
        description="Why the values may be certified although the model leaves more than noise: the certificate says "
        "it. Left out: it is refused then.",
    )
