"""Certificates that were written before the suites were called `drivers.conformance` still run, and are told."""

import importlib
import sys

import pytest

from drivers import conformance


def test_the_old_name_gives_the_same_suites_and_warns_whoever_imports_it():
    sys.modules.pop("drivers.contract", None)
    with pytest.warns(DeprecationWarning, match=r"drivers\.conformance") as warned:
        old = importlib.import_module("drivers.contract")
    assert len(warned) == 1
    assert {name: getattr(old, name) for name in old.__all__} == {
        name: getattr(conformance, name) for name in conformance.__all__
    }
