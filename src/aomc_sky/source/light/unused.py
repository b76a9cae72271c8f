"""What is not used: of a caller an error, of a file a note, in one sentence each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from aomc_sky.errors import UsageError
from aomc_sky.formats.sky_toml.keys import SKY_TOML
from aomc_sky.options import AMOUNTS, CLEAR_SKY, LIGHTS, MODEL, READING, WEATHER_FILES, listed, say
from aomc_sky.source.light.brightness import (
    DIFCOL,
    Brightness,
    Broadband,
    Cloudless,
    Levelled,
    OfTheSky,
    PerBand,
    Shares,
)
from aomc_sky.source.light.said import Said, Speakers, callers_of, is_diffuse_only, moment_said, sun_said
from aomc_sky.source.light.skies import OF_IRRADIANCES, OF_MODEL, Perez, Sky

_PLACE = ("zenith_deg", "azimuth_deg", "time", "latitude_deg", "longitude_deg")
_DISC = ("disc", "disc:False")
_LIGHT = (*AMOUNTS, *WEATHER_FILES, "row", "spectrum", *CLEAR_SKY, "altitude_m")
OF_SKY = ("coefficients", *MODEL, "polarisation")
"""Inputs of a diffuse sky."""
_SKY = (*OF_SKY, *LIGHTS, *READING)
_OTHER_SKY = "; write {sky:perez} for another sky"


def refuse_unused(speakers: Speakers, answer: Brightness, sky: Sky, given: Iterable[str] = ()) -> None:
    """Raise for what a caller says and the light has no use for; `given` are further inputs of his."""
    names = (*names_said(speakers), *given)
    used = {*answer.names, *sky.names, "diffuse_only"}
    is_alone = is_diffuse_only(speakers)
    is_placed = sun_said(speakers).zenith_deg is not None and not sky.is_whole
    is_missed = is_placed and not answer.has_beam and not is_alone  # a warning asks for the beam
    if is_missed or needs_sun(speakers, answer, sky):
        used |= set(_PLACE)
    used |= {"altitude_m"} if "time" in names and "time" in used else set()
    if isinstance(sky, Perez) and sky.shape is None and not isinstance(_inner(answer), Cloudless):
        used -= set(OF_IRRADIANCES)
    used |= {*(_DISC if answer.has_beam and not is_alone else ()), *(["polarisation"] if sky.has_sun else [])}
    hint = _hint(sky, answer) | (dict.fromkeys((*_PLACE, *_DISC), "; leave it out") if is_alone else {})
    shape = f" of {sky.shape.text}" if isinstance(sky, Perez) and sky.shape is not None else ""
    refuse_names(names, used, light=str(answer), sky=f"{sky.made_of}{shape}", hint=hint)


def needs_sun(speakers: Speakers, answer: Brightness, sky: Sky) -> bool:
    """Whether the beam, the amounts, the law of the sky or the pattern of its polarisation depends on the sun."""
    has_pattern = sky.has_sun and any(one.polarisation is not None for one in speakers)
    is_launched = answer.has_beam and not is_diffuse_only(speakers)
    has_amounts = bool(answer.names)  # an answer of inputs, which none of the files is
    return is_launched or has_amounts or sky.needs_sun or has_pattern


def names_said(speakers: Speakers) -> tuple[str, ...]:
    """The inputs of a caller; a switch that is turned off in its own word."""
    callers = callers_of(speakers)
    is_off = sun_said(callers).disc is False
    return tuple(f"{name}:False" if name == "disc" and is_off else name for one in callers for name in one.names)


def refuse_names(names: Iterable[str], used: set[str], *, light: str, sky: str, hint: dict[str, str]) -> None:
    """Raise for names that are not used, with the reason of each question, and what to write instead (`hint`)."""
    idle = [name for name in names if name not in used]
    reasons = (
        ((*_PLACE, *_DISC, "diffuse_only"), "the scene has no beam"),
        (_LIGHT, f"the light is that of {light}"),
        (_SKY, f"the sky is {sky}"),
    )
    said = []
    for group, reason in reasons:
        if found := [name for name in idle if name in group]:
            advice = next((hint[name] for name in reversed(found) if name in hint), "")
            are, it = _are(found), "it" if len(found) == 1 else "them"
            advice = say(advice.removeprefix("; ").replace("leave it", f"leave {it}"))
            said.append(UsageError(f"{listed(found)} {are} not used: {reason}", advice).problems[0])
    if said:
        raise UsageError(said[0].message, said[0].advice, more=said[1:])


def _are(names: Sequence[str]) -> str:
    return "is" if len(names) == 1 else "are"


def _inner(answer: Brightness) -> Brightness:
    """The answer without a level."""
    return answer.of if isinstance(answer, Levelled) else answer


def _hint(sky: Sky, answer: Brightness) -> dict[str, str]:
    """What to write in the place of an input."""
    of_two, alone = "; it needs two of {dni}, {dhi} and {ghi}", "; leave it out"
    is_named = sky.is_whole and sky.name != "table"  # a file that is named alone has no other sky
    other_sky = "" if isinstance(sky, Perez) else alone if is_named else _OTHER_SKY
    cloudless = "; write {spectrum:spectrl2} for a cloudless sky"
    if not isinstance(answer, OfTheSky):
        cloudless = (
            "; leave it out, or leave out what says that light and write {spectrum:spectrl2} for a cloudless sky"
        )
    beam = f"{of_two} beside {sky.made_of}"
    if sky.is_whole:
        beam = f"{'; write' if is_named else f'{_OTHER_SKY}, or'} two of {{dni}}, {{dhi}} and {{ghi}} for a beam"
    return {
        **dict.fromkeys(("coefficients", *MODEL), other_sky),
        **dict.fromkeys(OF_IRRADIANCES, other_sky or of_two),
        **dict.fromkeys((*_PLACE, *_DISC), beam),
        "spectrum": of_two,
        **dict.fromkeys(CLEAR_SKY, cloudless),
        "polarisation": "; take a sky with a sun: {sky:perez}, {sky:cie} or {sky:harrison-coombes}",
        **dict.fromkeys(LIGHTS, "; it needs [atmosphere] in sky.toml"),
        **dict.fromkeys(READING, "; leave it out"),
    }


def notes_of_files(speakers: Speakers, answer: Brightness, sky: Sky, *, is_lit: bool) -> tuple[str, ...]:
    """Notes on what files say and the light has no use for."""
    notes = [note_of_sun(speakers, None)]
    for one in speakers:
        if one.is_file:
            notes += [f"{what} not used: {why}" for what, why in _unused_of(one, answer, sky, is_lit)]
    return tuple(filter(None, notes))


def _unused_of(one: Said, answer: Brightness, sky: Sky, is_lit: bool) -> Iterable[tuple[str, str]]:
    """What a file says and is not used, and why."""
    light, inner = f"the light is that of {answer}", _inner(answer)
    is_shape = is_lit and isinstance(sky, Perez) and sky.shape is one.perez
    is_heard = isinstance(inner, Broadband) and inner.amounts is one.perez
    if one.perez.has_set and not (is_shape or is_heard):
        other_sky = say(_OTHER_SKY) if sky.is_whole else ""
        yield f"{SKY_TOML}: [perez] is", f"the sky is {sky.made_of}{other_sky}" if not answer.has_beam else light
    elif idle := [name for name in one.perez.model if not is_lit or name not in sky.names]:
        shape = f" of {sky.shape.text}" if isinstance(sky, Perez) and sky.shape is not None else ""
        yield f"{SKY_TOML}: {' and '.join(idle)} {_are(idle)}", f"the sky is {sky.made_of}{shape}"
    is_of_toml = one.sun.origin == SKY_TOML and not one.sun.is_empty
    if is_of_toml and sky.is_whole and not (answer.has_beam or one.polarisation):
        yield f"{SKY_TOML}: [sun] is", "the scene has no beam"
    if one.perez.spectrum is not None and "spectrum" not in answer.names:
        yield f"{SKY_TOML}: spectrum is", light
    if one.clear_sky and not isinstance(inner, Cloudless):
        yield f"{SKY_TOML}: [clear_sky] is", light
    if one.polarisation is not None and not (sky.has_sun and is_lit):
        yield f"{SKY_TOML}: polarisation is", f"the sky is {sky.made_of}" if is_lit else "all light is direct"
    levels = ("direct_irradiance", "diffuse_irradiance")
    idle = [name for name in levels if getattr(one, name) is not None]
    if idle and not isinstance(answer, (PerBand, Levelled)):
        yield f"{SKY_TOML}: {' and '.join(idle)} {_are(idle)}", light
    if one.shares is not None and not isinstance(inner, Shares):
        yield f"{DIFCOL}: its direct fractions are", light


def note_of_sun(speakers: Speakers, true_zenith_deg: float | None) -> str:
    """The note where a time, a weather file or a model says where the sun is, and files say it, too."""
    moment, suns = moment_said(speakers), [one.sun for one in speakers if one.is_file]
    said = sun_said(callers_of(speakers))
    if moment is None and suns and suns[0].origin.startswith(OF_MODEL) and said.zenith_deg is None:
        said, suns = suns[0], suns[1:]
    elif moment is None:
        return ""
    before = sun_said([Said(sun=one) for one in suns if not one.origin.startswith(OF_MODEL)])
    if before.zenith_deg is None:
        return ""
    zenith = said.zenith_deg if true_zenith_deg is None else true_zenith_deg
    return (
        f"{before.origin}: its sun at a zenith angle of {before.zenith_deg:g} and an azimuth of "
        f"{before.azimuth_deg or 0.0:g} degrees is not used: the sun is at {zenith:.4f} and {said.azimuth_deg:.4f} "
        f"({said.origin})"
    )
