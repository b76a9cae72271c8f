"""Python programs in processes forked from one that has large imports in memory: up in 0.02 s, not in 0.3 s to 1 s."""

import atexit
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from dataclasses import dataclass
from importlib import import_module

LONGEST_S = 600
"""What goes on for longer is ended, with all that it started."""
_LOOK_S = 0.005


@dataclass(frozen=True, kw_only=True, slots=True)
class Done:
    """How a program ended: exit code (negative for a signal) and both streams."""

    code: int
    out: str
    err: str


class ForkServer:
    """A process that has imported some modules and forks another one for each program; it starts with the first."""

    def __init__(self, *modules):
        self._modules = modules
        self._process = None

    def run(self, program, *arguments, folder=None, **variables):
        """Run a program with arguments, inside a folder, under changed environment variables (None takes one away)."""
        if self._process is None:
            command = [sys.executable, __file__, *self._modules]
            self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            atexit.register(self._process.communicate)
        changed = {name: value for name, value in {**os.environ, **variables}.items() if value is not None}
        task = [program, list(map(str, arguments)), str(folder or os.getcwd()), changed]
        self._process.stdin.write(json.dumps(task) + "\n")
        self._process.stdin.flush()
        return Done(**json.loads(self._process.stdout.readline()))


def _serve():
    for line in sys.stdin:
        task = json.loads(line)
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            child = os.fork()
            if child == 0:
                _be_the_child(out.fileno(), err.fileno(), *task)
            _wait_for(child)
            ended = {"code": os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])}
            for name, stream in (("out", out), ("err", err)):
                stream.seek(0)
                ended[name] = stream.read().decode(errors="replace")
        print(json.dumps(ended), flush=True)


def _wait_for(child):
    """Wait for the end of a child and leave its code to be taken; one that goes on for too long is killed."""
    end = time.monotonic() + LONGEST_S
    while os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
        if time.monotonic() > end:
            os.killpg(child, signal.SIGKILL)
        time.sleep(_LOOK_S)


def _be_the_child(out, err, program, arguments, folder, variables):
    code = 1
    try:
        os.setsid()
        for number, stream in ((0, os.open(os.devnull, os.O_RDONLY)), (1, out), (2, err)):
            os.dup2(stream, number)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(variables)
        sys.path[:0] = ["", *filter(None, variables.get("PYTHONPATH", "").split(os.pathsep))]
        if "numba" in sys.modules:
            sys.modules["numba"].config.reload_config()
        sys.argv = ["-c", *arguments]
        exec(compile(program, "<program>", "exec"), {"__name__": "__main__"})
        code = 0
    except SystemExit as leaving:
        code = leaving.code or 0
    except BaseException:
        traceback.print_exc()
    finally:
        threading._shutdown()
        atexit._run_exitfuncs()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code if isinstance(code, int) else 1)


if __name__ == "__main__":
    sys.path.pop(0)  # this folder
    for name in sys.argv[1:]:
        import_module(name)
    _serve()
