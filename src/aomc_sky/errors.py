"""All errors and warnings, each with exit code and name, and the position in a text file that an error names."""

from __future__ import annotations

import enum
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    import numpy as np

Member = TypeVar("Member", bound=enum.Enum)

MAX_PROBLEMS_SHOWN = 20
_MOST_SHOWN = 80  #: Characters of a value in a message

_UNSEEN = {
    *range(0x20),
    *range(0x7F, 0xA0),  # delete, and the controls of ISO 6429 in one byte
    0x61C,
    *range(0x200E, 0x2010),
    *range(0x2028, 0x202F),  # line separators, and what turns the order of letters
    *range(0x2066, 0x206A),
}
_ESCAPES = {code: chr(code).encode("unicode_escape").decode() for code in _UNSEEN}
_ESCAPES_IN_LINES = {code: text for code, text in _ESCAPES.items() if chr(code) not in "\n\t"}


def visible(text: str, *, keep_lines: bool = False) -> str:
    """A text of unknown origin as a terminal may show it: what would move, colour or reorder letters is escaped."""
    return text.translate(_ESCAPES_IN_LINES if keep_lines else _ESCAPES)


@dataclass(frozen=True, kw_only=True, slots=True)
class Problem:
    """One problem of a file, an option or an argument: where it is, what was found, and what to write instead."""

    #: Stable code, ``E104`` for an error or a warning of the same kind of a file, a word such as ``usage`` for all
    #: others; documented in docs/errors.md
    code: str
    message: str  #: The fault, and what was allowed
    advice: str = ""  #: What to write instead, beside the caret in a file
    field: str = ""  #: Name of the value for a person (``depth``, ``radiance``)
    path: str = ""  #: The file as the user named it; empty: an option, an argument or the machine
    #: Position of the first offending character. [1-based; 0 when the file as a whole is meant]
    line: int = 0
    column: int = 0
    text: str = ""  #: The source line, for the caret display
    width: int = 1  #: Characters to underline
    is_error: bool = True  #: False turns the problem into a warning

    @property
    def sentence(self) -> str:
        """Message and advice, without the place."""
        return f"{self.message}; {self.advice}" if self.advice else self.message

    def render(self) -> str:
        """Return the problem in the form that docs/errors.md promises, caret line included."""
        severity = "error" if self.is_error else "warning"
        path, message, advice = visible(self.path), visible(self.message), visible(self.advice, keep_lines=True)
        field = f"{visible(self.field)}: " if self.field else ""
        position = f"{path}:{self.line}:{self.column}" if self.line else path
        head = f"{position}: {severity}[{self.code}]: {field}{message}"
        if not self.line:
            return f"{head}\n      = {advice}" if advice else head
        # tabs would move the caret, control characters would disturb the terminal
        text = "".join(c if c.isprintable() else ("\N{REPLACEMENT CHARACTER}" if c != "\t" else " ") for c in self.text)
        shown, column = text, self.column
        if len(shown) > 120:
            start = max(0, column - 60)
            shown, column = shown[start : start + 120], column - start
        caret = " " * max(column - 1, 0) + "^" * max(1, min(self.width, 60))
        hint = f" {advice}" if advice else ""
        return f"{head}\n{self.line:5d} | {shown}\n      | {caret}{hint}"


class AomcSkyError(Exception):
    """Base of all errors that aomc-sky raises on purpose; a traceback of anything else is our bug.

    Examples
    --------
    >>> try:
    ...     sky.read_scene("no_such_folder")
    ... except sky.AomcSkyError as error:
    ...     print(type(error).__name__)
    InputFileError
    """

    exit_code = 1
    code = "error"  #: of its problem, where this has no code of a file

    def __init__(self, message: str = "", advice: str = "", *, field: str = "", more: Sequence[Problem] = ()) -> None:
        self.problems = (Problem(code=self.code, message=message, advice=advice, field=field), *more)
        super().__init__(message, advice)

    def __str__(self) -> str:
        return ". ".join(problem.sentence for problem in self.problems)


class UsageError(AomcSkyError):
    """Options that contradict each other or that name something unknown.

    Examples
    --------
    >>> sky.read_scene("inputs/clear_day", bins="thirds")
    Traceback (most recent call last):
        ...
    aomc_sky.errors.UsageError: bins must be one of 'equal', 'degrees', got 'thirds'
    """

    exit_code = 2
    code = "usage"


class MissingExtraError(AomcSkyError):
    """A feature needs a package that is not installed; the message names the extra to install."""

    exit_code = 2
    code = "missing-extra"


class SceneError(AomcSkyError):
    """The files are readable but describe a scene that cannot be sampled (a sky without light).

    Examples
    --------
    >>> sky.PerezSky(sun_zenith_deg=95.0, epsilon=5.0, delta=0.1)
    Traceback (most recent call last):
        ...
    aomc_sky.errors.SceneError: the sun must be above the horizon, ...
    """

    exit_code = 4
    code = "scene"


class PluginError(SceneError):
    """A sky model of another package cannot be imported, fails, or gives no sky; the cause is chained."""

    code = "plugin"


class FieldError(SceneError):
    """A radiance field that cannot be read as it is; `argument` is the one, or the key of [sky], that can help."""

    def __init__(
        self, message: str, advice: str = "", argument: str = "table", more: Sequence[FieldError] = ()
    ) -> None:
        super().__init__(message, advice, field=argument, more=[one for error in more for one in error.problems])


class AllocationError(AomcSkyError):
    """The photons cannot be shared out: too many of them, or no mass to share them over.

    Examples
    --------
    >>> sky.allocate([0.0, 0.0], 10)
    Traceback (most recent call last):
        ...
    aomc_sky.errors.AllocationError: all masses are zero, so there is nothing to share photons over
    """

    exit_code = 4
    code = "allocation"


class OutputError(AomcSkyError):
    """Writing failed: disk full, no permission, folder vanished. It leaves no half-written file.

    Examples
    --------
    >>> scene = sky.Scene(wavebands=[550.0], n_photons=10, components="uniform")
    >>> try:
    ...     sky.write_mcpl(scene.source(), "no_such_folder/photons.mcpl")
    ... except sky.errors.OutputError:
    ...     print("not written")
    not written
    """

    exit_code = 6
    code = "output"


class HostError(AomcSkyError):
    """The process that calls us does not compute as IEEE 754 has it, and it cannot be helped."""

    exit_code = 6
    code = "host"


class ForeignOutputError(OutputError):
    """The output folder belongs to another scene, seed or set of options."""

    exit_code = 5
    code = "foreign-output"


class InputWarning(UserWarning):
    """Something in an input file that a person should know about, but that can be read.

    Examples
    --------
    >>> import warnings
    >>> warnings.simplefilter("error", sky.InputWarning)  # doubtful input ends the program
    """


class ModelLimitWarning(UserWarning):
    """A model was asked for values outside its range, and limited them.

    Examples
    --------
    >>> import warnings
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     model = sky.PerezSky(sun_zenith_deg=30.0, epsilon=0.9, delta=0.1)
    ...     scene = sky.Scene(wavebands=[550.0], n_photons=1000, components=model)
    >>> print(caught[0].message)
    Perez sky, epsilon 0.9, Delta 0.1, limits 'radiance': epsilon below 1 counts as 1
    """


class InputFileError(AomcSkyError):
    """All problems of an input file, or of several, reported in one go.

    Examples
    --------
    >>> try:
    ...     sky.files.read_skydist("inputs/bad/nan_radiance.skydist.inp")
    ... except sky.InputFileError as error:
    ...     [problem.code for problem in error.problems]
    ['E302']
    """

    exit_code = 3

    def __init__(self, problems: Sequence[Problem]) -> None:
        super().__init__()
        self.problems, self.args = tuple(problems), (tuple(problems),)

    def __str__(self) -> str:
        shown = [p.render() for p in self.problems[:MAX_PROBLEMS_SHOWN]]
        hidden = len(self.problems) - len(shown)
        if hidden:
            shown.append(f"... and {hidden} more problem{'s' if hidden > 1 else ''}")
        return "\n".join(shown)


@dataclass(frozen=True, slots=True)
class Span:
    """Some characters of one line of a file; width 1 at an empty position."""

    line: int  #: [1-based]
    column: int  #: Column of the first character. [1-based]
    text: str  #: The whole line
    width: int = 1  #: Characters. [1 or more]

    def part(self, offset: int, width: int) -> Span:
        """The characters from `offset` on."""
        return Span(self.line, self.column + offset, self.text, width)

    def problem(
        self, path: str, code: str, message: str, *, field: str = "", advice: str = "", is_error: bool = True
    ) -> Problem:
        """A problem at this position of the file."""
        return Problem(
            path=path,
            line=self.line,
            column=self.column,
            code=code,
            field=field,
            message=message,
            advice=advice,
            text=self.text,
            width=self.width,
            is_error=is_error,
        )


NOWHERE = Span(0, 0, "")
"""The position of a problem that concerns the file as a whole."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SourceText:
    """Some complete lines of a text file, unchanged."""

    text: str  #: The lines, joined by a line feed
    path: str  #: The file as the user named it
    line: int  #: Line number of the first line of `text` in the file. [1-based]

    def problem(self, offset: int, code: str, field: str, message: str, advice: str = "", width: int = 1) -> Problem:
        """Return a problem that stands at a character of the text; the end of the text is allowed."""
        start = self.text.rfind("\n", 0, offset) + 1
        end = self.text.find("\n", offset)
        shown = self.text[start:] if end < 0 else self.text[start:end]
        line, column = self.line + self.text.count("\n", 0, offset), offset - start + 1
        span = Span(line, column, shown, max(1, min(width, len(shown) - column + 1)))
        return span.problem(self.path, code, message, field=field, advice=advice)


def require_kind(value: object, kind: type, advice: str) -> None:
    """UsageError unless a value is of this class."""
    if not isinstance(value, kind):
        raise UsageError(f"expected a {kind.__name__}, got {type(value).__name__}", f"write {advice}")


def require_switch(value: object, name: str) -> None:
    """UsageError unless a value is True or False: any text is true to Python."""
    if type(value).__name__ not in ("bool", "bool_"):
        raise UsageError(f"{name} is True or False, got {shown_value(value)}")


def require_one_of(allowed: Iterable[str], value: object, name: str) -> None:
    """Raise a UsageError unless a value is one of some words."""
    words = list(allowed)
    if value not in words:
        raise UsageError(f"{name} must be one of {', '.join(map(repr, words))}, got {value!r}")


def unmasked(name: str, value: Any) -> Any:
    """Return the numbers of a caller; SceneError if some are masked, because numpy would take those under the mask."""
    from numpy.ma import MaskedArray, is_masked

    def has_masked(given: Any) -> bool:
        if isinstance(given, (list, tuple)):
            is_deeper = any(issubclass(kind, (list, tuple, MaskedArray)) for kind in set(map(type, given)))
            return is_deeper and any(map(has_masked, given))
        return bool(is_masked(given))

    if has_masked(value):
        raise SceneError(f"{name} has masked values", "leave these entries out, or fill them with numbers")
    return value


def floats(name: str, value: Any) -> np.ndarray:
    """The numbers of a caller in float64; SceneError if some are masked, UsageError for what is no number.

    Without these checks None becomes NaN, and dates, texts of digits and records become numbers.
    """
    from numpy import asarray, float64

    try:
        array = asarray(unmasked(name, value))
        if array.dtype.kind in "biuf" or (array.dtype.kind == "O" and all(map(_is_number, array.flat))):
            return asarray(array, dtype=float64)
    except (TypeError, ValueError, OverflowError):
        pass  # rows of several lengths, whole numbers above the largest float64
    raise UsageError(f"{name} must be numbers, got {shown_value(value)}")


def number(name: str, value: Any) -> float:
    """The one number of a caller; SceneError if it is masked, UsageError for what is not one real number."""
    array = floats(name, value)
    if array.ndim or type(value).__name__ in ("bool", "bool_"):
        raise UsageError(f"{name} must be one number, got {shown_value(value)}")
    return float(array)


def _is_number(value: object) -> bool:
    """Whether an object is a real number: numpy's times and complex numbers have a `__float__`, too."""
    kind = getattr(getattr(value, "dtype", None), "kind", "f")
    return hasattr(value, "__float__") and kind in "biuf"


def shown_value(value: object) -> str:
    """What a caller gave, in one short line."""
    text = " ".join(repr(value).split())
    return text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}..."


def member_of(kind: type[Member], value: object, name: str) -> Member:
    """The member of an enumeration, from itself or its word in any case, else a UsageError.

    The word is its value, or its name where the values are no words.
    """
    if isinstance(value, kind):
        return value
    words = {member.value if isinstance(member.value, str) else member.name.lower(): member for member in kind}
    word = value.lower() if isinstance(value, str) else value
    require_one_of(words, word, name)
    return words[str(word)]
