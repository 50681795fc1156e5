"""A short recording as `measure` writes it; tests of commands put what they make beside it, each under its own name."""

import pytest

from tests.kit.command_line import QUICK, run


@pytest.fixture(scope="session")
def measured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("measured")
    arguments = ("--shots", 2, "--out", folder / "j.h5", "--json", folder / "j.json", "--sample", "S", "--comment", "c")
    done = run("measure", *QUICK, *arguments)
    assert done.returncode == 0, done.stderr
    return folder
