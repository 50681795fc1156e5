"""Names that people give, in pictures: shown as they are written."""

from __future__ import annotations

import pytest

from platform_daemon.core.reporting.figures import as_written, new_figure, png_of


@pytest.mark.parametrize("name", ["x$_1^$", r"a$\frac{b_1$", "_x", "5 $", r"\$1 and \$2", "_$_$"])
def test_a_name_is_drawn_as_it_is_written(name: str) -> None:
    figure, plain = new_figure(3, 2), new_figure(3, 2)
    for each, title, label in ((figure, as_written(name), {}), (plain, name, {"parse_math": False})):
        each.suptitle(title.strip(), **label)
    assert png_of(figure, 50) == png_of(plain, 50)


def test_a_name_that_begins_with_an_underscore_is_in_the_legend() -> None:
    axes = new_figure(3, 2).subplots()
    axes.plot([1.0, 2.0], label=as_written("_x"))
    assert [each.get_text().strip() for each in axes.legend().get_texts()] == ["_x"]
