"""White noise added to recorded shots: how much, in which parts, and where the second becomes the more precise one."""

import itertools
import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from drivers.errors import InputError, PlatformError
from platform_daemon.features.characterise.side_by_side.noise_curves import noise_report
from platform_daemon.features.characterise.side_by_side.noise_fits import added_sd
from platform_daemon.features.characterise.side_by_side.noise_parts import make_parts, parts_of, prepare_parts
from platform_daemon.features.characterise.side_by_side.noise_schema import NoiseDraw, NoisePart
from platform_daemon.features.characterise.side_by_side.sweep import (
    LEVELS,
    NoiseOptions,
    named,
    parse_levels,
    parse_shard,
    sweep_of,
)
from platform_daemon.features.characterise.tables import characterisation_task, characterise
from platform_daemon.features.fit.batch.executors import WorkerPool, in_this_process
from platform_daemon.features.fit.fit_request import FitSettings
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.ring_down_series import jewels, write_ring_downs

OPTIONS = NoiseOptions(None, 1.5)


@pytest.fixture(scope="module")
def specimens(tmp_path_factory):
    """Two recordings of three shots each, with their tasks and reports."""
    folder = tmp_path_factory.mktemp("pair")
    paths = [write_ring_downs(folder / f"{name}.h5", jewels(3)) for name in ("first", "second")]
    tasks = [characterisation_task(path, FitSettings(), None, 0.001) for path in paths]
    with in_this_process() as workers:
        reports = [characterise(task, workers, lambda what, share: None) for task in tasks]
    return tasks, reports


@pytest.fixture(scope="module")
def sweep(specimens):
    return replace(sweep_of(*specimens, OPTIONS), levels=(0.5, 1.5), draws=75)  # a part is two shots


def made(folder, sweep, shard=(1, 1)):
    prepare_parts(folder, sweep)
    with in_this_process() as workers:
        make_parts(folder, sweep, shard, workers, lambda share: None)


def test_so_much_is_added_that_the_mean_over_the_channels_is_the_level():
    own = np.array([14e-3, 21e-3, 55e-3])  # fig:noise_plot
    for level in (0.03, 0.17, 1.5):
        assert np.mean(np.hypot(own, added_sd(own, level))) == pytest.approx(level, rel=1e-6)
    with pytest.raises(InputError, match=r"own noise of 0\.03 A m2/s is above 0\.02") as refused:
        added_sd(own, 0.02)
    assert "0.03 A m2/s or more" in refused.value.remedy


def test_levels_are_those_of_the_paper_or_begin_at_the_own_noise(specimens):
    sweep = sweep_of(*specimens, OPTIONS)
    assert len(sweep.levels) == LEVELS == 30
    assert sweep.levels[-1] == pytest.approx(1.5)
    assert sweep.levels[0] >= 0.03
    with pytest.raises(InputError, match=r"first\.h5"):
        sweep_of(*specimens, NoiseOptions(1e-6, 1.5))


def test_a_level_needs_shots_with_a_calibration(specimens):
    tasks, reports = specimens
    unknown = reports[0].model_copy(update={"orientation_reference": None})
    with pytest.raises(InputError, match="nothing to add noise to"):
        sweep_of(tasks, [unknown, reports[1]], OPTIONS)


@pytest.mark.parametrize("text", ["", "0.1", "1:0.1", "0:1", "a:b", "0.1:inf", "0.1:1:2", "nan:1"])
def test_a_range_of_levels_that_is_none(text):
    with pytest.raises(InputError, match="FROM:TO"):
        parse_levels(text)


@pytest.mark.parametrize("text", ["", "0/2", "3/2", "1", "1/2/3", "-1/2", "1/0"])
def test_a_shard_that_is_none(text):
    with pytest.raises(InputError, match="3/8"):
        parse_shard(text)


def test_ranges_shards_and_names_are_read(tmp_path):
    assert parse_levels("0.03:1.5") == (0.03, 1.5)
    assert parse_shard("3/8") == (3, 8)
    assert named([tmp_path / "a" / "x.h5", tmp_path / "b" / "x.h5"]) == ["x-1", "x-2"]
    assert named([tmp_path / "x.h5", tmp_path / "y.h5"]) == ["x", "y"]


def parts_by_hand(sweep, spread):
    """Every fit is right on average and `spread` (specimen, level) off, every third fit of the first level failed."""
    rng, found = np.random.default_rng(3), []
    for part in sweep.parts:
        fits = []
        for k, level, draw in itertools.product(part.settings.frames, range(len(sweep.levels)), range(sweep.draws)):
            failed = level == 0 and draw % 3 == 0
            f, *turn = spread[part.specimen][level] * rng.standard_normal(4)
            vector = None if failed else tuple(turn)
            fits.append(NoiseDraw(frame=k, level=level, f_nat_hz=None if failed else 213.0 + f, rodrigues_rad=vector))
        found.append(NoisePart(specimen=part.specimen, fits=tuple(fits)))
    return found


def test_curves_count_failed_fits_and_cross_where_they_do(specimens, sweep):
    reference = specimens[1][0].orientation_reference.model_copy(update={"rodrigues_rad": (0.0, 0.0, 0.0)})
    reports = [report.model_copy(update={"orientation_reference": reference}) for report in specimens[1]]
    found = noise_report(sweep, parts_by_hand(sweep, ((1e-3, 4e-3), (2e-3, 2e-3))), reports)
    first, second = (curve.points for curve in found.curves)
    assert [point.failed for point in first] == [75, 0]
    assert {point.fits for point in first} == {225}
    assert first[1].f_nat_mad_hz == pytest.approx(0.674 * 4e-3, rel=0.15)
    # A third has failed and counts as far away: of those that are left, three quarters are nearer than the median.
    assert first[0].f_nat_mad_hz == pytest.approx(1.150 * 1e-3, rel=0.15)
    assert second[1].orientation_median_rad == pytest.approx(1.538 * 2e-3, rel=0.15)
    for crossing in found.break_even:
        assert 0.5 < crossing.interval_am2_per_s[0] <= crossing.level_am2_per_s <= crossing.interval_am2_per_s[1] < 1.5
    turned = noise_report(sweep, parts_by_hand(sweep, ((4e-3, 4e-3), (1e-3, 1e-3))), reports)
    assert {crossing.reason for crossing in turned.break_even} == {"the second is more precise at every level"}
    never = noise_report(sweep, parts_by_hand(sweep, ((1e-3, 1e-3), (4e-3, 4e-3))), reports)
    assert {crossing.reason for crossing in never.break_even} == {"the second is not more precise at the highest level"}


@pytest.mark.long
def test_shards_make_what_one_run_makes_and_a_killed_one_goes_on(sweep, specimens, tmp_path):
    small = replace(sweep, draws=50)
    made(tmp_path / "whole", small)
    made(tmp_path / "shards", small, (1, 2))
    with pytest.raises(InputError, match="parts are missing"):
        parts_of(tmp_path / "shards", small)
    made(tmp_path / "shards", small, (2, 2))
    assert parts_of(tmp_path / "shards", small) == parts_of(tmp_path / "whole", small)
    one = tmp_path / "whole" / "part-00000.json"
    before = (tmp_path / "whole" / "part-00001.json").stat().st_mtime_ns
    one.unlink()  # as if it had been killed before
    made(tmp_path / "whole", small)
    assert one.is_file()
    assert (tmp_path / "whole" / "part-00001.json").stat().st_mtime_ns == before
    report = noise_report(small, parts_of(tmp_path / "whole", small), specimens[1])
    for point in report.curves[0].points:
        assert point.failed < 0.05 * point.fits
        assert point.f_nat_mad_hz == pytest.approx(point.f_nat_mad_predicted_hz, rel=0.5)
        assert point.orientation_median_rad == pytest.approx(point.orientation_predicted_rad, rel=0.5)


def test_parts_of_another_sweep_and_broken_ones_are_refused(sweep, tmp_path):
    prepare_parts(tmp_path, sweep)
    prepare_parts(tmp_path, sweep)
    with pytest.raises(InputError, match="draws, parts differ"):
        prepare_parts(tmp_path, replace(sweep, draws=3))
    for k in range(len(sweep.parts)):
        (tmp_path / f"part-{k:05d}.json").write_text("{")
    with pytest.raises(InputError, match="no part of a noise sweep"):
        parts_of(tmp_path, sweep)
    (tmp_path / "plan.json").write_text("{}")
    with pytest.raises(InputError, match="no plan"):
        prepare_parts(tmp_path, sweep)


def test_workers_that_die_end_it_with_a_remedy_and_keep_what_is_made(sweep, tmp_path):
    prepare_parts(tmp_path, sweep)
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), initializer=os._exit, initargs=(1,)) as pool:
        workers = WorkerPool(pool, 1)
        with pytest.raises(PlatformError, match="a part of the sweep was lost") as lost:
            make_parts(tmp_path, sweep, (1, 1), workers, lambda share: None)
    assert "BrokenProcessPool" in lost.value.why
    assert "parts that are made stay" in lost.value.remedy


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--noise", "0.03:1.5", "--from", "x.h5"), ("--noise", "--compare")),
        (("--compare", "x.h5", "y.h5", "--shard", "1/2"), ("--shard", "--noise")),
        (("--compare", "x.h5", "y.h5", "--noise", "1:1"), ("FROM:TO",)),
        (("--compare", "x.h5", "y.h5", "--noise", "1:2", "--shard", "1/2", "--merge"), ("--merge",)),
        (("--compare", "x.h5", "y.h5", "--from", "z.h5"), ("--compare", "--from")),
        (("--compare", "x.h5", "y.h5"), ("x.h5", "no such file")),
    ],
)
def test_options_that_do_not_go_together(arguments, words):
    assert_one_line_error(here("characterise", *arguments), 2, *words)


@pytest.mark.long
def test_two_specimens_side_by_side_are_a_folder(specimens, tmp_path):
    paths = [task.path for task in specimens[0]]
    done = here("characterise", "--compare", *paths, "--noise", "0.1:1.5", "--out", tmp_path / "c")
    assert done.returncode == 0, done.stderr
    assert "break-even" in done.stdout or "the more precise one" in done.stdout
    for name in ("fit_plot_first", "fit_plot_second", "amplitude_plot", "noise_plot"):
        assert (tmp_path / "c" / "figures" / f"{name}.svg").read_text().startswith("<?xml")
        assert (tmp_path / "c" / "figures" / f"{name}.pdf").read_bytes().startswith(b"%PDF")
    page = (tmp_path / "c" / "report.html").read_text()
    assert "http" not in page.replace("http://www.w3.org", "")
    assert (tmp_path / "c" / "report.pdf").read_bytes().startswith(b"%PDF")
    table = (tmp_path / "c" / "tables" / "model_params_fit_result.tex").read_text()
    assert table.count(r"\\") == 5  # a heading, and two windows of each
