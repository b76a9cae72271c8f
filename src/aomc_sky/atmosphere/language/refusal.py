"""What a code block is refused for: problems with their place, gathered until there are enough."""

from __future__ import annotations

from dataclasses import dataclass, field

from aomc_sky.errors import MAX_PROBLEMS_SHOWN, InputFileError, Problem, SourceText

BLOCK_CODE = "E403"


class RefusalError(Exception):
    """A problem of the text between two offsets; whoever catches it knows the file."""

    def __init__(self, start: int, end: int, message: str, advice: str = "") -> None:
        self.start, self.end, self.message, self.advice = start, end, message, advice
        super().__init__(message)


@dataclass(slots=True)
class Problems:
    """The problems of one code block."""

    source: SourceText
    subject: str  #: what the block gives, for messages
    found: list[Problem] = field(default_factory=list)

    def add(self, refusal: RefusalError) -> None:
        """Note a problem; with more than are ever shown, end the reading at once."""
        width = max(1, refusal.end - refusal.start)
        self.found.append(
            self.source.problem(refusal.start, BLOCK_CODE, self.subject, refusal.message, refusal.advice, width)
        )
        if len(self.found) > MAX_PROBLEMS_SHOWN:
            self.raise_found()

    def raise_found(self) -> None:
        """Raise all problems together, if there are any."""
        if self.found:
            raise self.error()

    def error(self) -> InputFileError:
        """Return the error that says all problems, in the order of the file."""
        return InputFileError(sorted(self.found, key=lambda one: (one.line, one.column)))
