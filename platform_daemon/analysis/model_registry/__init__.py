"""Models that a diagnosis has made better: named, versioned, never overwritten, with the evidence for them.

model.py (what is adopted) - draft.py (from a diagnosis, or refused) - library.py (on disk) - names.py (names wherever a
variant is accepted) - receiver.py (what is undone in the samples before a fit) - evidence.py (who, when,
from which data).
"""

from .adopted_model import AdoptedModel, AdoptedTerm
from .adoption import AdoptionRefused, draft
from .evidence import digests
from .library import Library, UnknownModel
from .resolve import Variant, label_of, model_of, resolve, under_model

__all__ = [
    "AdoptedModel",
    "AdoptedTerm",
    "AdoptionRefused",
    "Library",
    "UnknownModel",
    "Variant",
    "digests",
    "draft",
    "label_of",
    "model_of",
    "resolve",
    "under_model",
]
