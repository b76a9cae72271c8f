"""A pseudo-terminal, and what a person would see on it."""

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


class Seen:
    """Bytes that arrived, read while they come, for a terminal that nobody reads is soon full."""

    def __init__(self, master):
        self._master = master
        self._parts = []
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self):
        with contextlib.suppress(OSError):  # the last user of the other end is gone
            while part := os.read(self._master, 65536):
                self._parts.append(part)

    def type(self, text):
        os.write(self._master, text.encode())

    def wait_for(self, text, seconds=30.0):
        limit = time.monotonic() + seconds
        while text not in self.text and time.monotonic() < limit:
            time.sleep(0.01)
        return text in self.text

    def finish(self):
        """Wait for the end of what is written; the other end must be closed."""
        self._thread.join(timeout=30)
        assert not self._thread.is_alive()

    @property
    def text(self):
        return b"".join(self._parts).decode()


@contextlib.contextmanager
def pseudo_terminal(width):
    """Give the descriptor of the end that a program writes to, and what was seen; complete after the block."""
    master, slave = os.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, width, 0, 0))
    seen = Seen(master)
    try:
        yield slave, seen
    finally:
        os.close(slave)
        seen.finish()
        os.close(master)


def start_in(slave, command, **how):
    """Start a program that this terminal controls: Ctrl-C reaches it."""

    def take_terminal():
        os.setsid()
        fcntl.ioctl(slave, termios.TIOCSCTTY, 0)
        # a shell lets its background jobs ignore it, and they their children
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    # the thread that reads holds no lock that these calls want
    streams = {"stdin": slave, "stdout": slave, "stderr": slave}
    return subprocess.Popen(command, preexec_fn=take_terminal, **streams, **how)  # noqa: PLW1509


def screen(text):
    """Lines that stand on a terminal at the end: what follows a carriage return is written over the line."""
    lines = []
    for line in re.sub(r"\x1b\[[0-9;]*m", "", text).split("\n"):
        shown = ""
        for part in line.split("\r"):
            part, clears, _ = part.partition("\x1b[K")
            assert part.isprintable(), repr(part)
            shown = part + ("" if clears else shown[len(part) :])
        lines.append(shown.rstrip())
    return lines
