"""A pseudo-terminal, and what a person would see on it."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import signal
import struct
import subprocess
import termios
import threading
import time
from collections.abc import Iterator, Sequence

_ESCAPE = re.compile(r"\x1b(?:\[([0-9;?]*)([A-Za-z]))?")


def set_width(descriptor: int, width: int) -> None:
    fcntl.ioctl(descriptor, termios.TIOCSWINSZ, struct.pack("HHHH", 24, width, 0, 0))


class Seen:
    """Bytes that arrived, read while they come, for a terminal that nobody reads is soon full."""

    def __init__(self, master: int) -> None:
        self._master = master
        self._parts: list[bytes] = []
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        with contextlib.suppress(OSError):  # the last user of the other end is gone
            while part := os.read(self._master, 65536):
                self._parts.append(part)

    def type(self, text: str) -> None:
        """Press keys."""
        os.write(self._master, text.encode())

    def wait_for(self, text: str, seconds: float = 30.0) -> bool:
        """Whether a text comes in time."""
        limit = time.monotonic() + seconds
        while text not in self.text and time.monotonic() < limit:
            time.sleep(0.01)
        return text in self.text

    def finish(self) -> None:
        """Wait for the end of what is written; the other end must be closed."""
        self._thread.join(timeout=30)
        assert not self._thread.is_alive()

    @property
    def text(self) -> str:
        return b"".join(self._parts).decode()


@contextlib.contextmanager
def pseudo_terminal(width: int) -> Iterator[tuple[int, Seen]]:
    """Give the descriptor of the end that a program writes to, and what was seen; complete after the block."""
    master, slave = os.openpty()
    set_width(slave, width)
    seen = Seen(master)
    try:
        yield slave, seen
    finally:
        os.close(slave)
        seen.finish()
        os.close(master)


def start_in(slave: int, command: Sequence[str], **how: object) -> subprocess.Popen:
    """Start a program that this terminal controls: Ctrl-C reaches it."""

    def take_terminal() -> None:
        os.setsid()
        fcntl.ioctl(slave, termios.TIOCSCTTY, 0)
        # a shell lets its background jobs ignore it, and they their children
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    # the thread that reads holds no lock that these calls want
    streams = {"stdin": slave, "stdout": slave, "stderr": slave}
    return subprocess.Popen(command, preexec_fn=take_terminal, **streams, **how)  # noqa: PLW1509


def screen(text: str, width: int) -> list[str]:
    """Lines that stand on a terminal at the end; only carriage return, clearing to the end and colours are known.

    A line that is too long goes on in the next one, where a carriage return no longer reaches its begin.
    """
    lines, line, column, k = [], "", 0, 0
    while k < len(text):
        if text[k] == "\n":
            lines.append(line.rstrip())
            line, column = "", 0
        elif text[k] == "\r":
            column = 0
        elif text[k] == "\x1b":
            found = _ESCAPE.match(text, k)
            assert found is not None
            assert found[2] in ("m", "K"), found[0]
            if found[2] == "K":
                line = line[:column]
            k = found.end()
            continue
        else:
            assert text[k].isprintable(), repr(text[k])
            if column == width:
                lines.append(line)
                line, column = "", 0
            line = line[:column].ljust(column) + text[k] + line[column + 1 :]
            column += 1
        k += 1
    return [*lines, line.rstrip()]
