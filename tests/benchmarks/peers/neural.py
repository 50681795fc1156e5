"""A small universal differential equation in jax: the sine and a network for the rest, through RK4."""

from __future__ import annotations

import importlib
import math
import time
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from platform_daemon.estimation.numerics.arrays import Array
from tests.benchmarks.peers.columns import Model
from tests.benchmarks.peers.datasets import Task
from tests.benchmarks.peers.sindy import overview
from tests.benchmarks.peers.states import states_of

HIDDEN, PER_PERIOD, WINDOW_PERIODS, WINDOWS, RATE, SEED = 16, 100, 2.5, 64, 5e-3, 0
SETTINGS = (
    f"-k sin phi + network(phi, phi' over its largest) 2-{HIDDEN}-{HIDDEN}-1 (tanh), k learnt too; RK4 with "
    f"{PER_PERIOD} steps a period over {WINDOWS} windows at most of {WINDOW_PERIODS:g} periods from smoothed states; "
    f"mean square of phi and phi'/w; Adam({RATE:g}), float64, seed {SEED}; ends at the time box"
)


def neural_rest(task: Task, box_s: float) -> tuple[Model, int]:
    """The model and how many steps of Adam the time box allowed, compilation included."""
    jax: Any = importlib.import_module("jax")
    optax: Any = importlib.import_module("optax")
    jax.config.update("jax_enable_x64", True)
    began = time.process_time()
    w, speed = overview(task)
    windows = _windows(task, w)
    parts = _network()
    rule = optax.adam(RATE)
    state = rule.init(parts)
    loss = _loss(jax, jax.numpy.asarray(windows), speed / w)

    @jax.jit
    def step(parts: Any, state: Any) -> tuple[Any, Any, Any]:
        value, slope = jax.value_and_grad(loss)(parts)
        change, state = rule.update(slope, state)
        return optax.apply_updates(parts, change), state, value

    steps = 0
    while time.process_time() - began < box_s:
        parts, state, value = step(parts, state)
        value.block_until_ready()
        steps += 1
    return _model([np.asarray(p) for p in parts], w, speed), steps


def _network() -> list[Array]:
    rng = np.random.default_rng(SEED)
    sizes = ((2, HIDDEN), (HIDDEN, HIDDEN), (HIDDEN, 1))
    weights = [rng.standard_normal(s) / math.sqrt(s[0]) * (1e-2 if s[1] == 1 else 1.0) for s in sizes]
    return [np.array(1.0), *_with_biases(weights)]


def _with_biases(weights: list[Array]) -> list[Array]:
    """Each weight followed by its bias."""
    return [part for weight in weights for part in (weight, np.zeros(weight.shape[1]))]


def _windows(task: Task, w: float) -> Array:
    """(windows, steps, 2): phi and phi'/w on the grid of the integrator, of all training records."""
    found, step_s = [], 2.0 * math.pi / w / PER_PERIOD
    length = int(WINDOW_PERIODS * PER_PERIOD)
    for record in task.train:
        s = states_of(record)
        at = np.arange(s.time_s[0], s.time_s[-1], step_s)
        both = np.stack([CubicSpline(s.time_s, s.phi)(at), CubicSpline(s.time_s, s.v / w)(at)], axis=1)
        count = max(1, min(WINDOWS // len(task.train), 2 * (at.size - length) // length))
        found += [both[k : k + length] for k in np.linspace(0, at.size - length, count).astype(int)]
    return np.array(found)


def _loss(jax: Any, windows: Any, largest: float) -> Any:
    """Mean square error of all windows, as a function of the network."""
    jnp, h = jax.numpy, 2.0 * math.pi / PER_PERIOD

    def rates(y: Any, parts: Any) -> Any:
        k, a, a0, b, b0, c, c0 = parts
        hidden = jnp.tanh(jnp.tanh(y / jnp.array([1.0, largest]) @ a + a0) @ b + b0)
        return jnp.stack([y[:, 1], -k * jnp.sin(y[:, 0]) + (hidden @ c + c0)[:, 0]], axis=1)

    def loss(parts: Any) -> Any:
        def forward(y: Any, _: Any) -> tuple[Any, Any]:
            one = rates(y, parts)
            two = rates(y + 0.5 * h * one, parts)
            three = rates(y + 0.5 * h * two, parts)
            four = rates(y + h * three, parts)
            y = y + h / 6.0 * (one + 2.0 * two + 2.0 * three + four)
            return y, y

        _, run = jax.lax.scan(forward, windows[:, 0], None, length=windows.shape[1] - 1)
        return jnp.mean((run - jnp.swapaxes(windows, 0, 1)[1:]) ** 2)

    return loss


def _model(parts: list[Array], w: float, speed: float) -> Model:
    """For scipy."""
    k, a, a0, b, b0, c, c0 = parts

    def torque(phi: float, v: float, t: float) -> float:
        hidden = np.tanh(np.tanh(np.array([phi, v / speed]) @ a + a0) @ b + b0)
        return w * w * (float((hidden @ c)[0] + c0[0]) - float(k) * math.sin(phi))

    return Model(torque, {"sine": float(k) * w * w}, speed)
