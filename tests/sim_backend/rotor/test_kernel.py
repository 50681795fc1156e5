import re

from sim_backend.rotor import kernel
from sim_backend.rotor.motion import march


def test_every_file_with_a_kernel_is_part_of_the_stamp():
    marked = {p for p in kernel.FOLDER.rglob("*.py") if re.search(r"^@kernel$", p.read_text(), re.MULTILINE)}
    assert marked
    assert {str(p.relative_to(kernel.FOLDER)) for p in marked} <= set(kernel.FILES)


def test_a_change_in_any_kernel_file_changes_the_stamp(tmp_path):
    for name in kernel.FILES:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes((kernel.FOLDER / name).read_bytes())
    assert kernel.stamp(tmp_path) == kernel.STAMP
    for name in kernel.FILES:
        text = (tmp_path / name).read_text()
        (tmp_path / name).write_text("# other physics\n" + text)
        assert kernel.stamp(tmp_path) != kernel.STAMP
        (tmp_path / name).write_text(text)


def test_numba_keeps_and_asks_for_kernels_under_that_stamp():
    assert march._cache._cache_file._source_stamp == kernel.STAMP  # noqa: SLF001 numba's own
