"""Every tuned number of the diagnosis is a field of `Thresholds` that says its meaning and what set it."""

import ast
import re
from collections import Counter
from dataclasses import fields

import pytest

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from tests.kit.data import ROOT

PACKAGE = ROOT / "platform_daemon/diagnosis"
SOURCES_OF_NUMBERS = (PACKAGE / "thresholds.py", *sorted(PACKAGE.glob("*_thresholds.py")))
OTHERS = sorted(set(PACKAGE.rglob("*.py")) - {*SOURCES_OF_NUMBERS})

PLAIN_FLOATS = {0.0, 0.5, 1.0, 2.0, 1e-300}  # factors of formulas, and the guard against a division by 0
PLAIN_INTEGERS = range(4)  # indices, dimensions, and the three parameters of a start

PROGRESS = "shares of the progress that is shown"
ALLOWED = {
    "diagnose.py": ([0.1, 0.15, 0.15, 0.7, 0.8, 0.85, 0.9], PROGRESS),
    "findings/rotor_findings.py": ([100.0], "percent"),
    "findings/undeclared_weight.py": ([100.0], "percent"),
    "fluctuation/process.py": ([4.0], "the differences of a second derivative"),
    "fluctuation_diagnosis.py": ([100.0], "percent"),
    "findings/random_walk.py": ([1e-14, 1e-9, 0.25, 10.0], "tolerances and brackets of a root; a decade"),
    "findings/verdict.py": ([4.0, 100.0, 100.0, 100.0], "the bracket of a root; per cent"),
    "regression/torque_response.py": ([3.0, 3.0], "the weights of the Runge-Kutta method"),
    "report.py": ([10.0, 10.0], "decimal logarithms"),
    "rigid_body/found_error.py": ([10.0, 1e3, 1e3], "millimetres, decimal digits"),
    "selection/select_effects.py": ([4], "quarters of a band"),
    "selection/stepwise.py": ([0.15, 0.25, 0.3], PROGRESS),
    "selection/torque_sets.py": ([0.15, 0.25], PROGRESS),
    "shots/kicked_motion.py": ([1e-9, 4], "rounding; the rows of the kernel's basis"),
    "shots/linearisation.py": ([4, 4, 6, 8], "the rows of the kernel's basis"),
}

SOURCES = {"noise", "digits", "physics", "Akaike", "cost", "drawing", "D", "A", "r4", "unset"}


def is_tuned(value):
    """True for a number that could be another one."""
    if type(value) is float:
        return value not in PLAIN_FLOATS
    return type(value) is int and value not in PLAIN_INTEGERS


def tuned_numbers(path):
    nodes = ast.walk(ast.parse(path.read_text()))
    return sorted(n.value for n in nodes if isinstance(n, ast.Constant) and is_tuned(n.value))


def declared():
    """Of each field of each group: (group, name, its comment on the same line or on the line above)."""
    for text in (source.read_text() for source in SOURCES_OF_NUMBERS):
        lines = text.splitlines()
        for group in ast.parse(text).body:
            if isinstance(group, ast.ClassDef) and group.name != "Thresholds":
                for node in group.body:
                    if isinstance(node, ast.AnnAssign):
                        line = lines[node.lineno - 1]
                        comment = line if "#" in line else lines[node.lineno - 2]
                        yield group.name, node.target.id, comment.partition("#")[2].strip()


def test_tuned_numbers_are_in_thresholds_only():
    found = {str(path.relative_to(PACKAGE)): tuned_numbers(path) for path in OTHERS}
    assert {name: numbers for name, numbers in found.items() if numbers} == {n: a[0] for n, a in ALLOWED.items()}


def test_a_number_in_code_would_be_seen(tmp_path):
    (tmp_path / "code.py").write_text("NEAR = 0.03\n\ndef f(x):\n    return x[: 12] if x[0] > -18.0 else x[1]\n")
    assert tuned_numbers(tmp_path / "code.py") == [0.03, 12, 18.0]


@pytest.mark.parametrize(("group", "name", "comment"), list(declared()), ids=lambda text: text[:30])
def test_a_threshold_says_its_meaning_and_what_set_it(group, name, comment):
    bracket = re.search(r"\[(.+?)\]", comment)
    assert bracket, f"{group}.{name} does not say what set it"
    assert len(comment.replace(bracket[0], "").strip()) > 3, f"{group}.{name} has no meaning"
    for source in re.split(r"; |, ", bracket[1]):
        word = re.split(r"[: ]", source)[0]
        known = word in SOURCES or source.startswith(("was ", "3.3 "))
        tests = list((ROOT / "tests/diagnosis").rglob(f"{word}.py")) if word.startswith("test_") else []
        assert known or tests, f"{group}.{name}: {source!r} is no source"


def test_every_threshold_is_used_and_none_twice_declared():
    groups = {type(getattr(THRESHOLDS, f.name)).__name__: f.name for f in fields(THRESHOLDS)}
    code = "\n".join(path.read_text() for path in OTHERS)
    names = Counter((groups[group], name) for group, name, _ in declared())
    assert len(names) > 200
    assert max(names.values()) == 1
    assert [pair for pair in names if not re.search(rf"\.{pair[1]}\b", code)] == []


def test_thresholds_cannot_be_changed_by_accident():
    with pytest.raises(AttributeError):
        THRESHOLDS.selection.level_p = 0.5
