"""What is published says the same everywhere: versions of the package, of the conda recipe and of what they need."""

import re
import tomllib

import aomc_sky
from tests.support.shared import REPOSITORY

PROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
RECIPE = (REPOSITORY / "recipe" / "recipe.yaml").read_text()
CONDA_NAMES = {"matplotlib": "matplotlib-base"}  # what conda-forge calls it without its windows


def listed(section):
    """Requirements of a section of the recipe: `numpy >=1.26`."""
    body = re.search(rf"^ +{section}:[^\n]*\n((?: +- .*\n)+)", RECIPE, re.MULTILINE)
    return set(re.findall(r"- (.+)", body[1]))


def as_conda(requirements):
    parts = [re.fullmatch(r"([\w-]+)(>=[\d.]+)", requirement) for requirement in requirements if ";" not in requirement]
    assert all(parts)
    return {f"{CONDA_NAMES.get(part[1], part[1])} {part[2]}" for part in parts if part}


def test_recipe_is_of_this_version_and_needs_what_the_package_needs():
    assert re.search(r'^  version: "(.+)"$', RECIPE, re.MULTILINE)[1] == aomc_sky.__version__
    assert ">=" + re.search(r'^  python_min: "(.+)"$', RECIPE, re.MULTILINE)[1] == PROJECT["requires-python"]
    assert listed("run") - {"python >=${{ python_min }}"} == as_conda(PROJECT["dependencies"])
    extras = PROJECT["optional-dependencies"]
    users = ("weather", "plot", "completion", "dask", "hdf5", "mcpl", "netcdf")
    assert extras["all"] == [f"aomc-sky[{','.join((*users, 'bench'))}]"]
    assert listed("run_constraints") == set().union(*(as_conda(extras[name]) for name in users))
    assert "- hatchling >=1.27" in RECIPE


def test_every_requirement_has_a_lower_bound_and_no_address_stands_where_none_is_known():
    extras = [one for name, extra in PROJECT["optional-dependencies"].items() if name != "all" for one in extra]
    needed = [one for one in (*PROJECT["dependencies"], *extras) if not one.startswith("aomc-sky[")]
    assert [one for one in needed if ">=" not in one] == []
    assert "urls" not in PROJECT
    assert not re.search(r"^(url|repository-code):", (REPOSITORY / "CITATION.cff").read_text(), re.MULTILINE)
