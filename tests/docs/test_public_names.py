"""The lazily loaded public names: all known to the type checker; versions stand in one place."""

import ast
import re
import tomllib
from importlib.metadata import version

import pytest

import aomc_sky
from tests.support.shared import REPOSITORY


def test_stub_names_what_the_package_loads():
    stub = ast.parse((REPOSITORY / "src/aomc_sky/__init__.pyi").read_text())
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    names = {alias.asname or alias.name: node.module for node in imports for alias in node.names}
    homes = {name: f"aomc_sky.{module}" for name, module in aomc_sky._PUBLIC.items()}
    homes |= {name: f"aomc_sky.{module}".rpartition(".")[0] for name, module in aomc_sky._PUBLIC_MODULES.items()}
    assert names == homes


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'no_such_name'"):
        aomc_sky.no_such_name  # noqa: B018


def test_version_stands_in_one_place():
    assert version("aomc-sky") == aomc_sky.__version__
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    assert "version" not in project
    assert "version" in project["dynamic"]
    cited = re.search(r"^version: (\S+)$", (REPOSITORY / "CITATION.cff").read_text(), re.MULTILINE)
    assert cited[1] == aomc_sky.__version__
    assert f"## {aomc_sky.__version__}" in (REPOSITORY / "CHANGELOG.md").read_text()


def test_streams_of_the_version_stand_in_the_changelog():
    from aomc_sky.plan.streams import STREAM_VERSION

    streams = (REPOSITORY / "CHANGELOG.md").read_text().split("### Streams", 1)[1]
    assert f"`{STREAM_VERSION}`" in streams
