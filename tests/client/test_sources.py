"""The client as a whole: what it imports, that both clients are alike, and that no operation of REST is forgotten."""

import ast
import inspect
import json
import re
from importlib import import_module

import pytest

from platform_daemon.client import operations as table
from platform_daemon.core.web.openapi_file import OPENAPI_FILE
from tests.kit import sync_client
from tests.kit.imports import loaded

MODULES = [path.stem for path in sorted(sync_client.SOURCE.glob("*.py")) if path.stem != "__init__"]
SCHEMA = json.loads(OPENAPI_FILE.read_text())
IN_SCHEMA = {
    operation["operationId"]: (method.upper(), path, operation)
    for path, methods in SCHEMA["paths"].items()
    for method, operation in methods.items()
}


def test_the_client_loads_nothing_heavy_and_nothing_that_windows_lacks():
    posix = "sys.modules.update(dict.fromkeys(('fcntl', 'termios', 'resource', 'pwd', 'grp')))"
    heavy = ("numpy", "scipy", "numba", "matplotlib", "fastapi", "h5py", "pandas", "xarray", "typer", "rich", "IPython")
    assert loaded(f"{posix}; import platform_daemon.client", heavy) == []


def test_the_synchronous_client_is_written_from_the_other_one():
    """If not: `python -m tests.kit.sync_client`."""
    assert {path.name: path.read_text() for path in sorted(sync_client.TARGET.glob("*.py"))} == sync_client.made()


def classes(package):
    for module in MODULES:
        found = import_module(f"platform_daemon.client.{package}.{module}")
        for name, each in inspect.getmembers(found, inspect.isclass):
            if each.__module__ == found.__name__:
                yield name.replace("Async", ""), each


def public(cls):
    return {name.replace("aclose", "close") for name in vars(cls) if not name.startswith("_")}


def test_both_clients_have_the_same_methods_with_the_same_arguments():
    synchronous, asynchronous = dict(classes("sync")), dict(classes("aio"))
    assert set(synchronous) == set(asynchronous)
    for name, cls in synchronous.items():
        other = asynchronous[name]
        assert public(cls) == public(other), name
        for method in public(cls) - {"close"}:
            if inspect.isfunction(getattr(cls, method)):
                both = [inspect.signature(getattr(each, method)).parameters for each in (cls, other)]
                assert list(both[0]) == list(both[1]), (name, method)


def test_every_operation_of_the_interface_has_a_method_or_a_reason():
    assert set(table.operations()) | set(table.WITHOUT_METHOD) == set(IN_SCHEMA)
    assert not set(table.operations()) & set(table.WITHOUT_METHOD)
    for name, operation in table.operations().items():
        assert (operation.method, operation.path) == IN_SCHEMA[name][:2]


def test_every_method_that_the_table_names_is_there():
    found = dict(classes("sync"))
    for operation in table.operations().values():
        cls, _, method = operation.sent_by.partition(".")
        assert hasattr(found[cls], method), operation.sent_by


def calls():
    """Operation and model of every call of the transport in the source."""
    for module in MODULES:
        for node in ast.walk(ast.parse((sync_client.SOURCE / f"{module}.py").read_text())):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                words = [each for each in node.args if isinstance(each, ast.Constant) and isinstance(each.value, str)]
                if node.func.attr in ("get", "post", "items") and len(node.args) > 1 and words:
                    yield words[0].value, ast.unparse(node.args[0]), node.func.attr


@pytest.mark.parametrize(("operation", "model", "how"), [each for each in calls() if each[0] in IN_SCHEMA])
def test_an_answer_is_read_as_the_model_that_the_interface_declares(operation, model, how):
    responses = IN_SCHEMA[operation][2]["responses"]
    schema = next(
        found["content"]["application/json"]["schema"] for status, found in responses.items() if status[0] == "2"
    )
    name = schema["$ref"].rpartition("/")[2]
    if how == "items":
        items = SCHEMA["components"]["schemas"][name]["properties"]["items"]["items"]
        name = items.get("$ref", "str").rpartition("/")[2]
    assert model == name


@pytest.mark.long
def test_help_says_of_an_argument_what_it_means_with_unit_and_limits():
    from platform_daemon.client import Client

    text = inspect.getdoc(Client.measure)
    assert "field_t: Excitation field, T" in text
    assert "[above 0, at most 1]" in text
    names = list(inspect.signature(Client.measure).parameters)
    assert {"shots", "field_t", "rx_s", "window", "sample"} < set(names)


@pytest.mark.parametrize("name", sorted(set(dict(classes("sync"))) - {"Transport"}))
def test_help_names_every_argument_of_every_method(name):
    cls = dict(classes("sync"))[name]
    for method in public(cls):
        function = getattr(cls, method)
        if inspect.isfunction(function):
            text = inspect.getdoc(function) or ""
            arguments = set(inspect.signature(function).parameters) - {"self", "values"}
            assert [each for each in arguments if not re.search(rf"\b{each}\b", text)] == [], method
