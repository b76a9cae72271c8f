"""One `Problem`: every error of ours has at least one, with a code, the message, and what to write."""

import json
import pickle
import re
from importlib.resources import files

import pytest

import aomc_sky as sky
from aomc_sky import errors
from aomc_sky.errors import AomcSkyError, InputFileError, Problem
from tests.support.fault_rows import command


def classes(base=AomcSkyError):
    return [base, *(one for below in base.__subclasses__() for one in classes(below))]


OURS = [one for one in classes() if one is not InputFileError and one.__module__.startswith("aomc_sky.")]


@pytest.mark.parametrize("kind", OURS, ids=lambda kind: kind.__name__)
def test_every_error_is_a_problem_and_survives_a_process(kind):
    error = kind("what was found", "what to write")
    again = pickle.loads(pickle.dumps(error))
    for one in (error, again):
        assert str(one) == "what was found; what to write"
        (problem,) = one.problems
        assert (problem.code, problem.message, problem.advice) == (kind.code, "what was found", "what to write")
    assert str(kind("alone")) == "alone"


def test_codes_are_those_of_the_schema():
    schema = json.loads((files("aomc_sky.cli") / "error.schema.json").read_text())
    pattern = schema["properties"]["error"]["properties"]["problems"]["items"]["properties"]["code"]["pattern"]
    assert all(re.match(pattern, kind.code) for kind in OURS)
    assert not re.match(pattern, "unheard-of")


def test_problems_of_a_file_survive_a_process():
    error = InputFileError([Problem(code="E104", message="found", advice="write", path="a.inp", line=2, column=3)])
    assert pickle.loads(pickle.dumps(error)).problems == error.problems
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_json_has_message_and_advice_of_an_option_apart(capsys):
    words = "run --wavelengths 443 --out new --sky overcast --disc --polarisation 0.5 --json"
    assert command(*words.split()) == 2
    problems = json.loads(capsys.readouterr().out)["error"]["problems"]
    assert [problem["message"].partition(" (")[0] for problem in problems] == ["--disc", "--polarisation"]
    assert problems[0]["message"].endswith("is not used: the scene has no beam")
    assert problems[0]["advice"].startswith("it needs two of --dni (dni=), --dhi (dhi=) and --ghi (ghi=)")
    assert problems[1]["advice"].startswith("take a sky with a sun: --sky perez")


def test_one_sentence_for_python():
    with pytest.raises(sky.UsageError) as caught:
        sky.weather_scene(wavebands=[443.0], epsilon=3.0)
    (problem,) = caught.value.problems
    assert (problem.code, problem.advice) == ("usage", "add delta")
    assert str(caught.value) == "how bright are sun and sky? epsilon without delta; add delta"


def test_the_place_is_an_argument_or_a_file():
    with pytest.raises(sky.UsageError) as caught:
        sky.weather_scene(wavebands=[443.0], sun_zenith_deg=200.0)
    assert caught.value.problems[0].field == "sun_zenith_deg"
    assert caught.value.problems[0].path == ""
    assert errors.NOWHERE.problem("a.csv", "E700", "found").path == "a.csv"
