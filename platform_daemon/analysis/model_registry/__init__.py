"""Models that a diagnosis has made better: named, versioned, never overwritten, with the evidence for them.

adopted_model.py (what is adopted) - adoption.py (from a diagnosis, or refused) - library.py (on disk) - resolve.py
(names wherever a model is accepted, and what it corrects in the samples before a fit) - evidence.py (who, when, from
which data).
"""

from .adopted_model import AdoptedModel, AdoptedTerm
from .adoption import AdoptionRefused, model_from_diagnosis
from .evidence import file_digests
from .library import Library, UnknownModel
from .resolve import ModelChoice, label_of, model_of, resolve, with_receiver_correction

__all__ = [
    "AdoptedModel",
    "AdoptedTerm",
    "AdoptionRefused",
    "Library",
    "ModelChoice",
    "UnknownModel",
    "file_digests",
    "label_of",
    "model_from_diagnosis",
    "model_of",
    "resolve",
    "with_receiver_correction",
]
