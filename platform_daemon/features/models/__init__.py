"""Adopted models: a library of named, versioned models."""

from platform_daemon.core.registry import Command, Feature

FEATURE = Feature(
    routes=(".routes",),
    tag=("models", "Declared models, and those that were adopted from diagnoses"),
    errors=(".library",),
    commands=(Command(name="models", attribute="models_app", help="Adopted models: list, show, retire."),),
)
