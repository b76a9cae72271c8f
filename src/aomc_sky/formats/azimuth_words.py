"""From where azimuths count and which way, as names, attributes, lines of files and options say it."""

from __future__ import annotations

import re
from collections.abc import Callable

from aomc_sky.directions import AzimuthConvention
from aomc_sky.errors import UsageError
from aomc_sky.formats.report import quoted

AZIMUTH_FORMS = (
    "'clockwise from north', or from east, south, west, the sun or the antisun, clockwise or counterclockwise"
)
SAY_AZIMUTH = f"write --azimuth-convention (azimuth_convention=) {AZIMUTH_FORMS}"
ASSUMED_AZIMUTH = (
    "does not say from where azimuths count; they are taken from +x (east) towards +y (north), as in skydist.inp; "
    "--azimuth-convention (azimuth_convention=) says otherwise"
)

_PHRASES = (
    (r"(?<=\w)'s\b", ""),
    (r"\bn/a\b", "unknown"),
    (r"\b(?:light |that )*(?:comes?|coming|arrives?|arriving) from\b", " "),
    (r"is the horizontal angle between\b.*", "clockwise"),  # the definition of CF
    (r"[-+]?\b(?:0|180) ?(?:-|\N{EN DASH}|to|\.\.+) ?\+?(?:180|360)\b", " "),  # the range, and no statement
    (r"-+>|→", " to "),
    (
        r"(?<!from )(?<!from the )(?<!from \+)\bx(?:[ -]axis)? (?:is |points? )?to(?:wards?)?"
        r" (?=(?:the )?(?:north|south|west)\b)",
        "x ",
    ),
    (r"\bpoints? (?:to(?:wards?)? )?(?=(?:the )?(?:true )?(?:north|east|south|west)\b)", " "),
    (r"(?<!\d )(?<!\d)\bdeg(?:rees?)? (?=(?:[nesw]|north|east|south|west)\b(?! of))", "bearing "),
    (r"(?<!\w)-(?=[xy]\b)", "minus"),
    (r"\b(?:counter|anti)[ -]?clockwise\b", "ccw"),
    (r"\b(?:anti-? ?(?:sun|solar)|opposite (?:to |of )?(?:the )?(?:sun|solar))\b", "antisun"),
    (r"(?:\bdirection of )?\bforward[ -]?scatter(?:ing|ed)?(?: direction)?\b", "sun"),
    (r"(?:\bdirection of )?\bback(?:ward)?[ -]?scatter(?:ing|ed)?(?: direction)?\b", "antisun"),
    (r"(?<=[a-z]) ?[-\N{EN DASH}\N{MINUS SIGN}] ?(?=(?:view|sensor|sun|solar|saa|vaa|phi))", " less "),
    (r"\b(north|east|south|west)(?:wards?|er)(?:ly)?\b", r"to \1"),
)
"""What is more than one word, and the word for it."""

_FILLERS = (
    "the a an azimuth azimuths azimuthal angle angles is are and with in as it deg degree degrees rad radian radians "
    "count counts counted measured given increasing increases growing grows at sky view viewing sensor platform "
    "element true geographic due point direction axis enu all starting phi vaa increase grow sense rotation "
    "orientation convention definition az azi"
)
_WORDS = {
    **dict.fromkeys(("east", "e", "x"), "E"),
    **dict.fromkeys(("north", "n", "y"), "N"),
    **dict.fromkeys(("west", "w", "minusx"), "W"),
    **dict.fromkeys(("south", "s", "minusy"), "S"),
    **dict.fromkeys(("sun", "solar"), "O"),
    "antisun": "A",
    **dict.fromkeys(("clockwise", "cw"), "cw"),
    **dict.fromkeys(("ccw", "acw", "anticlockwise", "counterclockwise"), "ccw"),
    **dict.fromkeys(("to", "toward", "towards", "through", "via"), "to"),
    **dict.fromkeys(("from", "relative", "reference", "origin", "positive", "negative", "of"), None),
    "zero": "0",
    **dict.fromkeys(_FILLERS.split(), ""),
}
"""Words that are understood: letters for points, "" for those that say nothing, None for those that stay."""

_SPEAKS = re.compile(
    r"\b(?:east|north|west|south|sun|solar|antisun|a?c?cw|clockwise|relative|"
    r"opposite|reverse\w*|invert\w*|mirror\w*|\w*handed|magnetic|declination|grid|compass|heading|bow|ship|aircraft|"
    r"vehicle|bearing|plane|meridian|away|offset|goes|going|beam|ray|propagat\w+|travel\w*|photons?|mathematical\w*|ned|nwu|"
    r"meteorological|astronomical|nautical|minus[xy]|[xy][ -]axis|[ensw] (?:of|to|towards?|through|via) [ensw]|"
    r"to (?:north|east|south|west)|(?:at|to|towards?|through|via) [ensw])\b|"
    r"\b[ensw] ?=|[=\d] ?[ensw]\b|^\W*[ensw]\W*$|\b[ensw](?: ?[-,/] ?[ensw]){2,3}\b|\+[xy]\b"
)
"""Words of a text that is on where azimuths count; other texts are on something else."""
_MAY_SPEAK = re.compile(
    r"\b(?:from|positive|negative|reference|left|right|instrument|frame|conventions?|specular|hot ?spot|phi ?0"
    r"|nesw|nwse|disort|uvspec|libradtran|gendaylit|pvlib|aeronet|modis)\b"
)
"""Words that are on where azimuths count, except in a comment, which may be on anything."""

OTHER_AZIMUTHS = re.compile(
    r"(?=.*(?:\bazimut(?!h)|\bazimuth\w*winkel|方位))"
    r".*(?:nord|s[üuy]d|[oöø]st|\best\b|[wv]est|uhr|horaire|sonne|sole?i?l?\b|[北南東西]|時計|太陽)",
    re.I,
)
"""Texts on azimuths in other languages, which are not read."""

_ON_AZIMUTHS = re.compile(r"\b(?:azimuths?|phi|vaa)\b|\bazi?\b(?=\s*[:=(]|\s+0\b)", re.I)
"""Names of azimuths in a text."""
_POINT = r"\b(?:north|east|south|west|[nesw])\b"
_QUARTER = r"(?<!\d)(?:0|90|180|270|360) ?(?:deg\w*|°)?"
_WITHOUT_THE_WORD = re.compile(
    rf"\A\W*(?:(?:convention|orientation|compass|directions?|angles?)\W+)?"
    rf"(?:(?:{_POINT} ?[:=] ?{_QUARTER}|{_QUARTER} ?[:=] ?{_POINT})(?:[\s,;/]|and\b|\Z)+){{2,}}\W*\Z"
    r"|\bx(?:[ -]axis)?(?:\W|\b(?:is|points?|to|towards?|the|true)\b)+(?:north|south|west|[nsw])\b"
    r"|\bframe\W+(?:NED|NWU|SEU|WSU)\b"
    r"|\b(?:mirrored|flipped|swapped)\b.*\b(?:north|east|south|west)"
    r"|\b(?:north|east|south|west).*\b(?:mirrored|flipped|swapped)"
    r"|\b(?:angles|directions)\b.*\bin (?:the )?(?:ship|vessel|aircraft|instrument|body|platform)(?:'s)?"
    r" (?:coordinates|frame|axes)\b",
    re.I,
)
"""Texts on azimuths without the word: "North: 0 deg, East: 90 deg" and the like alone, or axes that are not ours."""


def is_on_azimuths(text: str, *, is_comment: bool = False) -> bool:
    """Whether a sentence is on where azimuths count, whatever else it may be on."""
    plain = text.replace("_", " ")
    if OTHER_AZIMUTHS.match(text) or _WITHOUT_THE_WORD.search(plain):
        return True
    return _ON_AZIMUTHS.search(plain) is not None and speaks_of_azimuths(plain, is_comment=is_comment)


_P, _N = "([ENWSOA])", r"([-+]?\d+(?:\.\d+)?)"
_Seen = tuple[str, float]
_STATEMENTS: tuple[tuple[re.Pattern[str], Callable[..., list[_Seen]]], ...] = tuple(
    (re.compile(rf"(?:{pattern})(?: |\Z)"), points)
    for pattern, points in (
        (rf"(?:positive )?{_P} of {_P}", lambda towards, start: [(towards, 90.0), (start, 0.0)]),
        (rf"(?:from |to )?{_P} {_N}", lambda point, angle: [(point, float(angle))]),
        (rf"{_N} {_P}", lambda angle, point: [(point, float(angle))]),
        (rf"(?:from|relative to|reference|origin) {_P}", lambda start: [(start, 0.0)]),
        (rf"(?:positive )?to {_P}(?: positive)?|{_P} positive|positive {_P}",
         lambda *towards: [(point, 90.0) for point in towards if point]),
        (rf"{_P} negative|negative (?:to )?{_P}", lambda *back: [(point, 270.0) for point in back if point]),
        (r"(?:positive )?c?cw(?: positive)?|of(?! [ENWSOA])", list),
        (r"relative", lambda: [("O", 0.0)]),
        (_P, lambda start: [(start, 0.0)]),
    )
)  # fmt: skip
"""Statements, and the azimuths that points have by them. [deg]"""

_ENU_DEG = {"E": 0.0, "N": 90.0, "W": 180.0, "S": 270.0, "O": 0.0, "A": 180.0}
"""Azimuth of a point of the compass from +x, or from the sun. [deg]"""
_WITHOUT_SENSE = (
    AzimuthConvention.NORTH_CLOCKWISE,
    AzimuthConvention.ENU_FROM_EAST,
    AzimuthConvention.FROM_SUN,
    AzimuthConvention.FROM_ANTISUN,
)
"""What a start alone means."""


class UnclearError(Exception):
    """Words on azimuths that are not understood, leave something open, or contradict each other."""


def speaks_of_azimuths(text: str, *, is_comment: bool = False) -> bool:
    """Whether a text is on where azimuths count, understood or not."""
    plain = _one_spelling(text)
    return bool(_SPEAKS.search(plain) or OTHER_AZIMUTHS.match(text) or (not is_comment and _MAY_SPEAK.search(plain)))


def convention_of(*texts: str, is_clockwise: bool = False) -> AzimuthConvention:
    """The convention that all texts together state.

    A start without a sense means clockwise from north, and counterclockwise from east, the sun and the antisun.
    `is_clockwise`: another source says so; alone it means from north. UnclearError.
    """
    seen: list[_Seen] = [] if texts else [("N", 0.0)]
    turns = {-1.0} if is_clockwise else set()
    for text in texts:
        words = _words(text)
        seen += _points(words, text)
        turns |= {1.0 if word == "ccw" else -1.0 for word in re.findall(r"\bc?cw\b", words)}
    shown = " and ".join(map(quoted, texts))
    if not seen:
        raise UnclearError(f"{shown} does not say from where azimuths count")
    fitting = [one for one in AzimuthConvention if turns <= {one.value[1]} and all(_has(one, *point) for point in seen)]
    if not fitting:
        raise UnclearError(f"{shown}: these words on azimuths contradict each other")
    if len(fitting) > 1:
        fitting = [one for one in fitting if one in _WITHOUT_SENSE]
    if len(fitting) != 1:
        raise UnclearError(f"{shown} does not say whether azimuths count clockwise or counterclockwise")
    return fitting[0]


def given_convention(value: AzimuthConvention | str) -> AzimuthConvention:
    """The convention that a caller gives, a member or words; UsageError."""
    try:
        return value if isinstance(value, AzimuthConvention) else convention_of(str(value))
    except UnclearError as error:
        raise UsageError(f"azimuth_convention: {error}; {SAY_AZIMUTH}") from None


def _has(convention: AzimuthConvention, point: str, angle: float) -> bool:
    """Whether a point has this azimuth in a convention."""
    offset, orientation = convention.value[:2]
    return convention.is_from_sun == (point in "OA") and (offset + orientation * angle - _ENU_DEG[point]) % 360.0 == 0.0


def _one_spelling(text: str) -> str:
    plain = text.lower().replace("_", " ")
    for pattern, word in _PHRASES:
        plain = re.sub(pattern, word, plain)
    return plain


def _words(text: str) -> str:
    """The words that say something, one blank between them; UnclearError for one that is not known."""
    kept = []
    for word in re.findall(r"[^\W\d_]+|[-+]?\d+(?:\.\d+)?", _one_spelling(text)):
        known = word if word[-1].isdigit() else _WORDS.get(word, "?")
        if known == "?":
            message = f"{quoted(text)} does not say clearly from where azimuths count: {quoted(word)} is not understood"
            raise UnclearError(message)
        kept.append(word if known is None else known)
    return re.sub(r"\b([ENWS]) \1\b", r"\1", " ".join(filter(None, kept)))  # +x (east)


def _points(words: str, text: str) -> list[_Seen]:
    """Points with their azimuths in all statements of a text."""
    seen: list[_Seen] = []
    while words:
        for pattern, points in _STATEMENTS:
            if match := pattern.match(words):
                seen += points(*match.groups())
                words = words[match.end() :]
                break
        else:
            raise UnclearError(f"{quoted(text)} does not say clearly from where azimuths count")
    return seen
