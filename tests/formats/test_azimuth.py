"""The twelve words for azimuths, and the names of the members: nothing else is a statement."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

import aomc_sky as sky
from aomc_sky.directions import to_enu_azimuth_deg
from aomc_sky.formats.azimuth import WORDS, convention_of, given_convention, words_of

NORTH_AND_EAST = {
    # azimuths of north and east in the file; of the sun and of 90 degrees counterclockwise from it, for the last four
    "clockwise from north": (0, 90), "counterclockwise from north": (0, 270), "clockwise from east": (270, 0),
    "counterclockwise from east": (90, 0), "clockwise from south": (180, 270), "counterclockwise from south": (180, 90),
    "clockwise from west": (90, 180), "counterclockwise from west": (270, 180),
    "clockwise from the sun": (0, 270), "counterclockwise from the sun": (0, 90),
    "clockwise from the antisun": (180, 90), "counterclockwise from the antisun": (180, 270),
}  # fmt: skip


@pytest.mark.parametrize("words", NORTH_AND_EAST)
def test_words_are_the_convention(words):
    convention, sun = convention_of(words), 30.0
    first, second = NORTH_AND_EAST[words]
    expected = (sun, sun + 90.0) if "sun" in words else (90.0, 0.0)
    assert to_enu_azimuth_deg([first, second], convention, sun).tolist() == list(expected)
    assert words_of(convention) == words
    for other in (words.upper(), f"  {words.replace(' ', '   ')} ", convention.name, convention.name.lower()):
        assert convention_of(other) is convention
    assert given_convention(convention) is given_convention(words) is convention


def test_every_member_has_words():
    assert set(WORDS) == set(NORTH_AND_EAST)
    assert set(WORDS.values()) == set(sky.directions.AzimuthConvention)


@pytest.mark.parametrize(
    "words",
    ["", "north", "from north", "clockwise", "from the sun", "E of N", "clockwise from the north", "0 is +x",
     "clockwise from north.", "not clockwise from north", "clockwise from magnetic north",
     "im Uhrzeigersinn von Nord", "0 to 360"],
)  # fmt: skip
def test_other_words_are_none(words):
    assert convention_of(words) is None
    with pytest.raises(sky.UsageError, match="is no convention"):
        given_convention(words)


@given(st.text(max_size=60))
def test_any_text_is_a_name_or_none(text):
    assert (convention_of(text) is None) == (" ".join(text.lower().split()) not in {
        *NORTH_AND_EAST, *(one.name.lower() for one in sky.directions.AzimuthConvention)
    })  # fmt: skip
