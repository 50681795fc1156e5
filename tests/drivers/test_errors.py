import re

import pytest

from drivers import errors


def test_an_error_reads_as_one_line_of_place_cause_and_remedy():
    error = errors.ConfigError("key 'x' is unknown", where="a.toml", why="it was renamed", remedy="write 'y'")
    assert str(error) == "a.toml: key 'x' is unknown. it was renamed. Remedy: write 'y'."


def test_line_breaks_of_a_foreign_message_do_not_break_the_line():
    assert "\n" not in str(errors.DeviceTimeout("no answer\nfor 5 s"))


def every_kind():
    todo = [errors.PlatformError]
    while todo:
        kind = todo.pop()
        yield kind
        todo.extend(kind.__subclasses__())


@pytest.mark.parametrize("kind", list(every_kind()))
def test_every_kind_has_a_title_and_a_meaning(kind):
    assert kind.title
    assert len(kind.__doc__) > 20


def test_the_tree_in_the_docstring_is_the_tree_in_the_code():
    for kind in every_kind():
        if kind.__module__ == "drivers.errors":
            assert re.search(rf"\b{kind.__name__} +{kind.http_status}  \w", errors.__doc__)
