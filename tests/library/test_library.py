"""The library without a daemon: signals of known truth, own arrays, fits, diagnoses; and each mistake."""

import inspect
import math
import re

import h5py
import numpy as np
import pytest

import platform_daemon as pd_
from platform_daemon.core.schemas.parameters import RODRIGUES
from tests.kit.imports import loaded
from tests.kit.recording_files import write_series

RATE_HZ = 10_000.0


@pytest.fixture(scope="module")
def sim():
    return pd_.simulate("jewel", phi_max_deg=53, seconds=0.6, noise="paper", seed=1, sampling_rate_hz=RATE_HZ)


@pytest.fixture(scope="module")
def fit(sim):
    return pd_.fit(sim, model="jewel", window="d30")


def test_the_names_are_there_and_none_is_loaded_before_it_is_used():
    assert sorted(pd_.__all__) == sorted(set(pd_.__all__))
    assert all(getattr(pd_, name) is not None for name in pd_.__all__)
    assert set(pd_.__all__) <= set(dir(pd_))
    assert loaded("import platform_daemon", ("numba", "numpy", "scipy", "pydantic", "importlib.metadata")) == []
    with pytest.raises(AttributeError, match="nothing"):
        pd_.nothing  # noqa: B018


def test_a_fit_finds_the_truth_of_a_simulated_signal(sim, fit):
    assert fit.good
    assert set(fit) == set(sim.truth)
    for name, estimate in fit.items():
        off = estimate.value - sim.truth[name]
        off = (off + math.pi) % (2 * math.pi) - math.pi if name == "psi_start_rad" else off
        assert abs(off) < 5 * estimate.std, name


def test_the_covariance_goes_with_its_names(fit):
    assert fit.covariance.shape == (len(fit.covariance_names),) * 2
    for k, name in enumerate(fit.covariance_names):
        assert fit.covariance[k, k] == pytest.approx(fit[name].std ** 2)


def test_a_table_a_frame_of_data_an_array_and_a_picture(fit, tmp_path):
    assert "f_nat_hz" in fit.table()
    assert fit.to_dataframe().attrs["units"]["f_nat_hz"] == "Hz"
    found = fit.to_xarray()
    assert found.residual.attrs["units"] == "A m^2/s"
    assert float(found.residual.std()) < 0.1
    assert fit.plot(tmp_path / "fit.png").axes
    assert (tmp_path / "fit.png").read_bytes().startswith(b"\x89PNG")


def test_the_same_seed_is_the_same_signal(sim):
    again, other = (
        pd_.simulate("jewel", phi_max_deg=53, seconds=0.6, seed=seed, sampling_rate_hz=RATE_HZ) for seed in (1, 2)
    )
    np.testing.assert_array_equal(again.signal(), sim.signal())
    assert not np.array_equal(other.signal(), sim.signal())


def test_own_arrays_are_fitted_with_the_noise_that_is_given(sim, fit):
    own = pd_.from_arrays(sim.time_s(), sim.signal(), noise=(0.014, 0.021, 0.055))
    found = pd_.fit(own, model="jewel")
    assert found.result.noise_source == "given"
    assert found["f_nat_hz"].value == pytest.approx(fit["f_nat_hz"].value, rel=1e-7)
    assert found["m_r_am2"].std == pytest.approx(fit["m_r_am2"].std, rel=0.1)


def test_several_frames_of_volts_and_an_angle(sim):
    both = pd_.from_arrays(sim.time_s(), voltage=np.stack([sim.signal(), -sim.signal()]), variant="jewel")
    fits = pd_.fit_frames(both)
    assert [each.good for each in fits] == [True, True]
    assert "m_r_am2" not in fits[0]
    assert len(fits.to_dataframe()) == 2
    time_s = np.arange(40_000) / 2000.0
    swing = pd_.from_arrays(time_s, angle_rad=0.3 * np.exp(-0.05 * time_s) * np.cos(2 * np.pi * 3.1 * time_s))
    assert pd_.fit(swing, window=10.0)["f_nat_hz"].value == pytest.approx(3.1, rel=0.02)
    assert swing.to_xarray().channel.values.tolist() == ["phi"]


@pytest.mark.long
def test_a_diagnosis_of_one_signal_writes_a_page(sim, tmp_path):
    report = pd_.diagnose([sim], model="jewel")
    assert report.verdict == "nothing_missing"
    assert "Nothing is missing" in report.text()
    assert report.to_html(tmp_path / "r.html").read_text().startswith("<!")


def test_a_recording_of_ours_and_an_angle_series_are_opened(tmp_path):
    series = tmp_path / "swing.h5"
    time_s = np.arange(4000) / 200.0
    with h5py.File(series, "w") as file:
        file["time"] = time_s
        file["signal"] = 0.3 * np.exp(-0.05 * time_s)[None] * np.cos(2 * np.pi * 3.1 * time_s)
    assert pd_.open(series).quantity() == "angle"
    ours = pd_.open(write_series(tmp_path / "ours.h5", 2))
    assert (ours.frames, ours.variant) == (2, "thread")


ARRAYS = np.ones((3, 100)) * np.sin(np.arange(100))
TIME = np.arange(100) / 1000.0
HOLES = np.delete(np.arange(140) / 1000.0, np.arange(60, 100))


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: pd_.from_arrays(TIME, ARRAYS.T), "transpose it"),
        (lambda: pd_.from_arrays(TIME, ARRAYS[:2]), r"shape \(2, 100\)"),
        (lambda: pd_.from_arrays(TIME[:-1], ARRAYS), "one time for each sample"),
        (lambda: pd_.from_arrays(HOLES, ARRAYS), "time has holes"),
        (lambda: pd_.from_arrays(TIME[::-1], ARRAYS), "time runs back"),
        (lambda: pd_.from_arrays(TIME[:20], ARRAYS[:, :20]), "longer signal"),
        (lambda: pd_.from_arrays(TIME, np.where(ARRAYS > 0.99, np.nan, ARRAYS)), "no finite numbers"),
        (lambda: pd_.from_arrays(TIME, ["a"] * 100), "no array of real numbers"),
        (lambda: pd_.from_arrays(TIME, angle_rad=45.0 * ARRAYS[0]), "may be degrees"),
        (lambda: pd_.from_arrays(TIME), "one of dmdt"),
        (lambda: pd_.from_arrays(TIME, ARRAYS, noise=(1.0, 2.0)), "noise"),
        (lambda: pd_.from_arrays(TIME, voltage=ARRAYS, sensitivity=np.zeros((3, 3))), "singular"),
        (lambda: pd_.fit(pd_.from_arrays(TIME, ARRAYS)), "--variant"),
        (lambda: pd_.fit(pd_.from_arrays(TIME, ARRAYS), model="jevel"), "jewel"),
        (lambda: pd_.fit(pd_.from_arrays(TIME, ARRAYS), model="jewel", terms=["drag"]), "quadratic_drag"),
        (lambda: pd_.fit(pd_.from_arrays(TIME, ARRAYS), model="jewel", frame=3), "frames go from 0 to 0"),
        (lambda: pd_.fit(pd_.from_arrays(TIME, ARRAYS), model="jewel", fixed={"f_nat_hz": -1.0}), "positive"),
        (lambda: pd_.simulate("jewel", phi_max_deg=120, seconds=1), "below 90"),
        (lambda: pd_.simulate("jewel", phi_max_deg=20, seconds=-1), "above 0"),
        (lambda: pd_.simulate("jevel", phi_max_deg=20, seconds=1), "jevel"),
        (lambda: pd_.simulate("jewel", phi_max_deg=20, seconds=1, noise="papers"), "is no noise"),
        (lambda: pd_.open("nowhere.h5"), "nowhere.h5"),
        (lambda: pd_.open("nowhere.csv"), "no such file"),
        (lambda: pd_.fit("a.h5"), r"a str is no recording.*open the file first"),
        (lambda: pd_.diagnose("a.h5"), r"a str is no recording.*open the file first"),
        (lambda: pd_.diagnose([]), "there is no recording"),
        (lambda: pd_.fit(pd_.from_arrays(TIME, ARRAYS), model="jewel", window="D30"), "no window 'D30'"),
        (lambda: pd_.fit(pd_.from_arrays(TIME, ARRAYS), model="jewel", window=[1, 2]), "no window"),
        (lambda: pd_.fit(pd_.from_arrays(TIME, ARRAYS), model="jewel", window=float("nan")), "no window nan"),
        (lambda: pd_.fit(pd_.from_arrays(TIME, ARRAYS), model="jewel", frame=0.5), "no numbers of frames"),
    ],
)
def test_a_mistake_is_one_error_with_a_remedy(make, says):
    with pytest.raises(pd_.InputError, match=says) as found:
        make()
    assert found.value.remedy
    assert "\n" not in str(found.value)


def test_a_signal_that_cannot_be_fitted_says_why(sim):
    noise = pd_.from_arrays(sim.time_s(), np.random.default_rng(1).standard_normal((3, len(sim.time_s()))))
    refused = pd_.fit(noise, model="jewel")
    assert not refused.good
    assert refused.reason
    assert "refused" in refused.table()
    with pytest.raises(pd_.InputError, match="refused"):
        refused["f_nat_hz"]
    assert set(RODRIGUES) <= set(sim.truth)


def test_help_names_every_argument_of_every_function():
    for name in pd_.__all__:
        found = getattr(pd_, name)
        methods = vars(found) if inspect.isclass(found) else {name: found}
        for method, function in methods.items():
            if inspect.isfunction(function) and not method.startswith("_"):
                text = inspect.getdoc(function) or ""
                arguments = set(inspect.signature(function).parameters) - {"self"}
                missing = [each for each in arguments if not re.search(rf"\b{each}\b", text)]
                assert not missing or "arguments and the errors are those of `" in text, (name, method, missing)
