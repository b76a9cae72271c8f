"""Words on azimuths: right, or refused; a wording means what a compass says, and nothing passes half understood."""

import contextlib
import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.directions import AzimuthConvention, to_enu_azimuth_deg
from aomc_sky.formats.azimuth_words import UnclearError, convention_of, given_convention, speaks_of_azimuths

ENU = {"east": 0.0, "north": 90.0, "west": 180.0, "south": 270.0}
SUN = 40.0

# text -> where the azimuths 0 and 90 of the file point: points of the compass, "sun" and what is beside it, or None
WORDS = {
    # test_every_wording_of_the_grammar_is_a_compass has the usual ones
    "from north": "north east", "enu_from_east": "east north", "anticlockwise from the east": "east north",
    "n of w": "west north", "north cw": "north east", "ccw from x": "east north", "S through W": "south west",
    "from north towards east": "north east", "from south positive eastwards": "south east",
    "positive west of south": "south west", "0 north 90 east": "north east", "S=0, E=-90, W=+90": "south west",
    "azimuth angle (0-360 deg) clockwise from true north": "north east", "clockwise from the -y axis": "south west",
    "from +x (east) towards +y (north)": "east north", "from north (0) to east (90)": "north east",
    "azimuth of the sky element; 0 is +x, growing towards +y": "east north", "from west, anti-clockwise": "west south",
    "north is 0 and azimuth increases to the west": "north west", "measured from south (west negative)": "south east",
    "zero at south, positive to the east": "south east", "degrees east of true north": "north east",
    "from north, counter clockwise positive": "north west", "positive clockwise from south": "south west",
    "90 = south, clockwise": "east south",
    "from the sun": "sun left", "relative to the sun": "sun left", "from_sun_clockwise": "sun right",
    "clockwise from the sun": "sun right", "counterclockwise from sun": "sun left", "relative azimuth": "sun left",
    "azimuth relative to the sun's azimuth, positive clockwise": "sun right", "sun = 0": "sun left",
    "from the anti-solar point": "antisun left", "opposite to the sun, clockwise": "antisun right",
    "180 = sun": "antisun left", "from_antisun": "antisun left", "sun at 180, clockwise": "antisun right",
    "": None, "measured": None, "cw": None, "from south": None, "from west": None, "0 to 360": None,
    "away from the sun": None, "magnetic north, clockwise": None, "clockwise from grid north": None,
    "not clockwise from north": None, "relative to ship heading": None, "from the bow, clockwise": None,
    "viewed from below, clockwise from north": None, "clockwise from north, counterclockwise": None,
    "azimuth of propagation clockwise from north": None, "mathematical, from east": None, "bearing": None,
    "from north to south": None, "from the sun towards east": None, "from north and from south": None,
    "right-handed from north": None, "azimuth of the sun": None, "north east": None, "cw from northeast": None,
    "positive": None, "clockwise negative from north": None, "from the principal plane": None, "inversely": None,
    "N→E": "north east", "pvlib": None, "NESW": None, "N-E-S-W": None, "specular direction = 0": None,
    "looking up, clockwise from north": None, "N E S W": None, "from north or east": None, "reverse of pvlib": None,
}  # fmt: skip


@pytest.mark.parametrize("text", WORDS)
def test_words(text):
    """The convention turns 0 and 90 degrees of the file to where the words put them."""
    if WORDS[text] is None:
        with pytest.raises(UnclearError):
            convention_of(text)
        return
    start, towards = WORDS[text].split()
    azimuth = ENU | {"sun": SUN, "antisun": SUN + 180.0}
    beside = {"left": azimuth[start] + 90.0, "right": azimuth[start] - 90.0}
    expected = np.mod([azimuth[start], (azimuth | beside)[towards]], 360.0)
    np.testing.assert_allclose(to_enu_azimuth_deg([0.0, 90.0], convention_of(text), SUN), expected)


def test_every_wording_of_the_grammar_is_a_compass():
    """Start and sense in all spellings: 4 points, 2 senses, and what the turn meets at 90 degrees."""
    ring = ["north", "east", "south", "west"]  # clockwise
    for start, (step, senses) in itertools.product(
        ring, ((1, ("clockwise", "cw")), (-1, ("counterclockwise", "anti-clockwise", "CCW")))
    ):
        towards = ring[(ring.index(start) + step) % 4]
        texts = [f"{sense} from {start}" for sense in senses] + [f"From the {start}, {sense}." for sense in senses]
        texts += [
            f"{towards} of {start}", f"{towards[0].upper()} of {start[0].upper()}", f"from {start} to {towards}",
            f"{start}=0, {towards}=90", f"0 = {start}; 90 = {towards}", f"from {start}, {towards} positive",
            f"{start}_{senses[0]}", f"{ring[(ring.index(start) - step) % 4]} negative, from {start}",
        ]  # fmt: skip
        for text in texts:
            convention = convention_of(text)
            assert to_enu_azimuth_deg([0.0, 90.0], convention).tolist() == [ENU[start], ENU[towards]], text


def test_members_are_words_and_a_standard_name_is_clockwise():
    for member in AzimuthConvention:
        assert convention_of(member.name) is convention_of(member.name.lower()) is given_convention(member) is member
    assert convention_of(is_clockwise=True).name == "NORTH_CLOCKWISE"
    assert convention_of("reference direction is due south", is_clockwise=True).name == "WEST_OF_SOUTH"
    with pytest.raises(UnclearError, match="contradict"):
        convention_of("counterclockwise from north", is_clockwise=True)


@pytest.mark.parametrize(
    ("texts", "convention"),
    [
        (("relative", "clockwise"), "FROM_SUN_CLOCKWISE"), (("relative", "relative azimuth angle"), "FROM_SUN"),
        (("from north", "positive clockwise"), "NORTH_CLOCKWISE"), (("from south", "clockwise"), "WEST_OF_SOUTH"),
        (("from north", "from east"), None), (("clockwise from north", "ccw"), None),
        (("relative", "from north"), None),
    ],
)  # fmt: skip
def test_texts_add_up_or_contradict_each_other(texts, convention):
    if convention is None:
        with pytest.raises(UnclearError):
            convention_of(*texts)
    else:
        assert convention_of(*texts).name == convention


@pytest.mark.parametrize("text", ["viewing azimuth angle", "azimuth of the sky element", "deg", "azimuth", "sensor 3"])
def test_other_texts_are_not_on_azimuths(text):
    assert not speaks_of_azimuths(text)


@given(st.text(max_size=30), st.sampled_from(["clockwise from north", "from south", "E of N", "sun=0", ""]))
def test_any_text_is_a_convention_or_unclear(text, words):
    for whole in (text, f"{text} {words}", f"{words}, {text}"):
        speaks_of_azimuths(whole)
        with contextlib.suppress(UnclearError):
            assert isinstance(convention_of(whole), AzimuthConvention)
