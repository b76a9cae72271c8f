"""A system that is not POSIX, as our package sees it in a process of its own.

What Windows lacks is taken away from our modules before any of them is imported: modules, functions, words of `open`,
signals; numpy and others keep theirs, for they ask for Linux and find it. What Windows does otherwise is done so: a
folder cannot be opened, and a file that is open can be neither removed nor replaced.
"""

import errno
import os
import signal
import sys

MODULES = ("fcntl", "resource", "termios", "pwd", "grp", "posix_ipc", "syslog")
_FUNCTIONS = """
    fork forkpty register_at_fork fdatasync pread preadv pwrite pwritev readv writev sendfile posix_fallocate
    posix_fadvise mkfifo mknod fchmod fchown chown lchown getuid geteuid getgid getegid getgroups getpgid getsid setsid
    killpg nice wait3 wait4 sched_getaffinity sched_setaffinity getloadavg uname confstr sysconf statvfs fstatvfs
    getxattr setxattr memfd_create pidfd_open pipe2 ttyname openpty confstr_names
"""
FUNCTIONS = tuple(_FUNCTIONS.split())
FLAGS = ("O_NONBLOCK", "O_NOFOLLOW", "O_CLOEXEC", "O_NOCTTY", "O_DIRECTORY", "O_SYNC", "O_DSYNC", "O_PATH", "O_TMPFILE")
SIGNALS = ("setitimer", "getitimer", "alarm", "pause", "pthread_sigmask", "sigwait", "siginterrupt")
_BINARY = 1 << 40  # the system here has no such word


def become():
    """Take away from this process what is not everywhere; there is no way back."""
    for name in MODULES:
        sys.modules[name] = None
    numbers = [name for name in vars(signal) if name.startswith(("ITIMER", "SIGPROF", "SIGALRM", "SIGHUP"))]
    _hide(os, (*FUNCTIONS, *FLAGS))
    _hide(signal, (*SIGNALS, *numbers))
    os.O_BINARY = _BINARY
    _open_binary_files_only()
    for name in ("unlink", "remove", "rmdir", "replace", "rename"):
        _refuse_open_files(name)


def _is_ours(depth):
    return str(sys._getframe(depth).f_globals.get("__name__", "")).startswith("aomc_sky.")


def _hide(module, names):
    hidden = {name: vars(module).pop(name) for name in names if hasattr(module, name)}

    def looked_up(name):
        if name not in hidden or _is_ours(2):
            raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}")
        return hidden[name]

    module.__getattr__ = looked_up


def _open_binary_files_only():
    real = os.open

    def opened(path, flags, mode=0o777, *, dir_fd=None):
        if _is_ours(2):
            assert flags & _BINARY, f"{path}: lines would end with two characters"
        if os.path.isdir(path):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)
        return real(path, flags & ~_BINARY, mode, dir_fd=dir_fd)

    os.open = opened


def _refuse_open_files(name):
    real = getattr(os, name)

    def refused(path, *rest, **named):
        for one in (path, *rest[:1]) if name in ("replace", "rename") else (path,):
            if _is_open(one):
                raise PermissionError(errno.EACCES, "another program uses this file", one)
        return real(path, *rest, **named)

    setattr(os, name, refused)


def _is_open(path):
    """Whether this process has the file open, by what Linux lists."""
    try:
        looked_for = os.stat(path, follow_symlinks=False)
    except OSError:
        return False
    for handle in os.listdir("/proc/self/fd"):
        try:
            if os.path.samestat(os.fstat(int(handle)), looked_for):
                return True
        except OSError:
            continue
    return False
