"""Tuned numbers of the estimation are declared in `thresholds`, each with its unit, its meaning and what set it."""

import ast
import math
import re
from dataclasses import fields
from pathlib import Path

import pytest

from platform_daemon import estimation
from platform_daemon.estimation.numerics.jit import sources_digest
from platform_daemon.estimation.thresholds import THRESHOLDS

PACKAGE = Path(estimation.__file__).parent
SECTIONS = [field.name for field in fields(THRESHOLDS)]
PLAIN = {0, 1, 2, 0.5}
TINY = 1e-300  # keeps a quotient or a logarithm of a power finite
BOUNDS = {"min", "max", "range", "maximum", "minimum", "clip"}

TYPICAL = "the typical size of a coefficient belongs to its torque term, which is one file"
ELLIPTIC = "coefficients of the pendulum's elliptic integrals and series"
STATISTICS = "moments of Gaussian noise and of its power"
GEOMETRY = "axes of space, sides, and points of a parabola"
QUARTERS = "quarters of a turn"
LAYOUT = "columns of an array"
NOT_TUNED = {
    "calibration/receiver_correction.py": (
        "order of the splines and coefficients of the stencil",
        {0.25, 4, 5, 105, 280},
    ),
    "calibration/transmit.py": ("degrees of freedom of six real numbers and four unknowns", {4, 6}),
    "compilation.py": (
        "a made-up record that warms the kernels up",
        {0.05, 0.1, 0.2, 0.3, 4.0, 200.0, 1200, 8000.0, 1e4},
    ),
    "cramer_rao.py": (GEOMETRY, {3}),
    "goodness_of_fit/collinearity.py": ("decimal digits", {10.0}),
    "goodness_of_fit/compression.py": ("the odd powers of a receiver that compresses", {3, 5}),
    "goodness_of_fit/noise_floor.py": (STATISTICS, {18.0, 35.0}),
    "goodness_of_fit/residual.py": (STATISTICS, {0.57721566490153286, 6.0}),
    "goodness_of_fit/residual_jacobian.py": (ELLIPTIC, {16.0}),
    "harmonic_estimator/demodulation.py": ("moments of a window", {0.25, 3.0, 4.0}),
    "harmonic_estimator/estimator.py": ("harmonics 1 to 4; elliptic integrals of a small parameter", {3.0, 4.0, 16.0}),
    "initial_guess/guess.py": (QUARTERS, {0.25, 1.5}),
    "initial_guess/harmonic_fit.py": (LAYOUT, {4}),
    "least_squares/progressive.py": ("2^60 half cycles are all", {60}),
    "moments/kernels.py": (LAYOUT, {3, 4, 7}),
    "moments/model_signal.py": ("coefficients of a Gauss quadrature", {4.0}),
    "moments/tabulated.py": (GEOMETRY, {3}),
    "noise/angle.py": (STATISTICS, {9.0, 12.0}),
    "noise/model.py": (STATISTICS, {0.0247, 3.0}),
    "noise/series.py": (STATISTICS, {2.3}),
    "noise/tones_and_drift.py": (STATISTICS, {6.0}),
    "numerics/chebyshev.py": ("a multiple of four nodes; decimal digits", {0.25, 4, 10.0}),
    "numerics/finite_differences.py": ("points of the stencil", {9}),
    "numerics/separate_functions.py": ("arguments of a term", {5}),
    "physics/driven.py": ("weights of a Runge-Kutta step of order 4; quarters of a period", {1.5, 3, 4, 6.0}),
    "physics/orbit.py": (ELLIPTIC, {0.25, 3, 4.0, 9.0}),
    "physics/quality.py": (ELLIPTIC, {0.25, 3.0}),
    "physics/rigid_rotor/equations.py": (
        "places of states and parameters; coefficients of Hertz's and Zhuravlev's contact and of a tangent's continued "
        "fraction; 40 time constants are all",
        {
            *range(3, 9),
            10,
            11,
            13,
            14,
            15,
            16.0,
            *range(18, 30),
            40.0,
            1e-7,
            0.125,
            0.25,
            0.375,
            0.75,
            1e-30,
            1e-12,
            105.0,
            420.0,
            945.0,
        },
    ),
    "physics/rigid_rotor/implicit_step.py": ("slopes of a Hertz disc's friction", {0.2, 0.25, 0.75, 1.5}),
    "physics/rigid_rotor/geometry.py": ("inertia of a sphere, force of a dipole", {0.4, 3.0}),
    "physics/rigid_rotor/rotor.py": ("cube root of a load, gravity", {3.0, 9.81}),
    "physics/rigid_rotor/swing.py": ("order of the method and its stages", {0.2, 7}),
    "physics/ring_down.py": (QUARTERS, {0.25, 3.0}),
    "physics/rotation.py": ("series of a rotation by a small angle", {12.0, 720.0}),
    "physics/torques/angle_dependent_damping.py": (TYPICAL, {2e-4, 4.0}),
    "physics/torques/bias_torque.py": (TYPICAL, {1e-2}),
    "physics/torques/coulomb_friction.py": (TYPICAL, {7e-4}),
    "physics/torques/cubic_restoring.py": (TYPICAL, {1e-2, 3.0}),
    "physics/torques/dahl_friction.py": (TYPICAL, {7e-4, 0.03, 0.25, 1e-9}),
    "physics/torques/dispatch.py": ("codes of the torque terms", {*range(3, 13), 1000, 0xFFFF}),
    "physics/torques/frequency_drift.py": (TYPICAL, {1e-6}),
    "physics/torques/frequency_settling.py": (TYPICAL, {1e-6, 1e-3}),
    "physics/torques/torque_course.py": (
        f"{TYPICAL}; coefficients of the cubic of Keys",
        {1e-4, 1e-2, 1e2, 3, 4, 1.5, 2.5, 4.5, 5.0},
    ),
    "physics/torques/hertz_friction.py": (TYPICAL, {7e-4, 3.0, 4.0}),
    "physics/torques/hertz_friction_under_weight.py": (TYPICAL, {7e-4, 1e-2, 3.0, 4.0}),
    "physics/torques/power_restoring.py": (TYPICAL, {1e-2, 4.0}),
    "physics/torques/quadratic_drag.py": (TYPICAL, {1e-3}),
    "physics/torques/restoring_anharmonicity.py": (TYPICAL, {1e-2}),
    "physics/torques/stribeck_coulomb_friction.py": (TYPICAL, {2e-4, 0.05}),
    "physics/torques/stribeck_friction.py": (TYPICAL, {2e-4, 0.05, 3.0, 4.0}),
    "physics/torques/torsion_stiffness.py": (TYPICAL, {1e-2}),
    "physics/torques/viscous_damping.py": (TYPICAL, {2e-4}),
    "physics/trajectory/basis_functions.py": (
        "coefficients of Hermite interpolation",
        {2.5, 3.0, 4.0, 6.0, 6.5, 7.0, 10.0, 15.0, 20.0, 34.0, 35.0, 39.0, 70.0, 84.0},
    ),
    "physics/trajectory/direct_chain.py": (LAYOUT, {3}),
    "physics/trajectory/half_cycle_chain.py": (LAYOUT, {3}),
    "physics/trajectory/half_cycle_table.py": (ELLIPTIC, {8.0, 10.0}),
    "physics/trajectory/initial_conditions.py": (ELLIPTIC, {0.25}),
    "physics/trajectory/table_range.py": (LAYOUT, {3, 4, 5}),
    "prepared_record.py": (GEOMETRY, {3}),
    "record.py": (GEOMETRY, {3}),
    "rotor_correction/coordinates.py": (GEOMETRY, {3}),
    "rotor_correction/motion.py": ("the four neighbours of a cubic", {4}),
    "screening/angle_cycles.py": (
        "mean of neighbours; parabola; variance of a third difference",
        {0.25, 1.5, 3, 4.0, 20.0},
    ),
    "screening/angle_motion.py": ("per cent", {100.0}),
    "screening/frequency_search.py": ("half of the bins below half the sampling rate", {4}),
    "screening/fundamental.py": (
        "coefficients of the Blackman-Harris window; the lowest harmonic that can be folded",
        {0.01168, 0.14128, 0.35875, 0.48829, 3, 4},
    ),
    "sensitivity.py": (GEOMETRY, {3}),
    "sliding_window.py": ("rounding of a quotient; points of a straight line with a test", {1e-9, 3}),
}
"""Numbers that nobody tuned, by file, with the reason."""
TABLEAU = "physics/trajectory/dormand_prince.py"


def numbers_of(tree):
    """Floats anywhere, and integers where they decide: constants, comparisons, bounds, loops, divisors, defaults."""
    found = set()
    for statement in tree.body:
        _collect(statement, found, decides=isinstance(statement, ast.Assign | ast.AnnAssign))
    return found


def _collect(node, found, *, decides):
    if isinstance(node, ast.JoinedStr):
        return
    if isinstance(node, ast.Constant):
        if type(node.value) is float or (type(node.value) is int and decides):
            found.add(node.value)
        return
    decides = decides or isinstance(node, ast.Compare | ast.arguments)
    for name, value in ast.iter_fields(node):
        if name == "decorator_list":
            continue
        here = decides
        if isinstance(node, ast.Call) and name != "func":
            here = decides or getattr(node.func, "id", getattr(node.func, "attr", "")) in BOUNDS
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.FloorDiv):
            here = decides or name == "right"
        if isinstance(node, ast.Subscript) and name == "slice":
            here = False
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                _collect(child, found, decides=here)


def sources():
    files = {path.relative_to(PACKAGE).as_posix(): path.read_text() for path in PACKAGE.rglob("*.py")}
    return {name: text for name, text in files.items() if not name.startswith("thresholds/") and name != TABLEAU}


def test_no_tuned_number_is_left_outside_the_thresholds():
    left = {}
    for name, text in sources().items():
        numbers = numbers_of(ast.parse(text)) - PLAIN - {TINY} - NOT_TUNED.get(name, ("", set()))[1]
        if numbers:
            left[name] = sorted(numbers)
    assert not left, "declare them in platform_daemon/estimation/thresholds"


def test_no_exception_is_out_of_date():
    texts = sources()
    stale = {
        name: sorted(allowed - numbers_of(ast.parse(texts.get(name, "")))) for name, (_, allowed) in NOT_TUNED.items()
    }
    assert not {name: numbers for name, numbers in stale.items() if numbers}


@pytest.mark.parametrize(
    "text",
    [
        "LIMIT = 7",
        "def f(x):\n    return x > 5",
        "def f(x):\n    return max(x, 8)",
        "def f(x):\n    return 0.3 * x",
        "def f(x):\n    return x // 6",
        "def f(x, n=9):\n    return x",
        "def f(x):\n    for _ in range(12):\n        x = -x",
    ],
)
def test_a_tuned_number_is_found(text):
    assert numbers_of(ast.parse(text)) - PLAIN


@pytest.mark.parametrize("section", SECTIONS)
def test_a_threshold_says_its_unit_its_meaning_and_what_set_it(section):
    for field in fields(getattr(THRESHOLDS, section)):
        about = field.metadata
        assert about["unit"], field.name
        assert about["meaning"], field.name
        assert about["source"], field.name


@pytest.mark.parametrize("section", SECTIONS)
def test_a_test_that_is_named_as_a_source_exists(section):
    for field in fields(getattr(THRESHOLDS, section)):
        for path in re.findall(r"(?:tests|docs)/\S+", field.metadata["source"]):
            assert (PACKAGE.parents[1] / path).exists(), field.name


@pytest.mark.parametrize("section", SECTIONS)
def test_a_threshold_is_used(section):
    text = "\n".join(sources().values())
    for field in fields(getattr(THRESHOLDS, section)):
        assert re.search(rf"\.{field.name}\b", text), field.name


@pytest.mark.parametrize("section", SECTIONS)
def test_a_threshold_is_finite(section):
    for field in fields(getattr(THRESHOLDS, section)):
        value = getattr(getattr(THRESHOLDS, section), field.name)
        assert all(math.isfinite(one) for one in (value if isinstance(value, tuple) else (value,))), field.name


def test_compiled_code_is_renewed_where_a_threshold_changes(monkeypatch):
    before = sources_digest()
    changed = PACKAGE / "thresholds/physics.py"
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + b"#" if path == changed else read(path))
    assert sources_digest.__wrapped__() != before
