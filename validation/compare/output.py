"""Writes files atomically: in full or not at all."""
import contextlib
import errno
import os
import secrets
import sys


def is_stdout(path):
    """Returns whether `path` is the standard output, to which the report is also printed."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(sys.stdout.fileno()))
    except (OSError, ValueError):
        return False


def is_stream(path):
    """Returns whether `path` is a pipe, a device or the standard output, which can't be replaced."""
    return is_stdout(path) or (os.path.exists(path) and not os.path.isfile(path)
                               and not os.path.isdir(path))


def names(path):
    """Returns the target of `path`, with links resolved, and the name of its temporary file. Raises OSError
    if the target is a folder, or a file without write permission."""
    target = os.path.realpath(path)
    if os.path.isdir(target) or not os.path.basename(path):
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
    # Replacing a file needs only permissions of its folder. A read-only file must be kept, nevertheless.
    if os.path.exists(path) and not os.access(path, os.W_OK):
        raise OSError(errno.EACCES, os.strerror(errno.EACCES))
    return target, f"{target}.{secrets.token_hex(8)}.part"


def check(path):
    """Raises OSError if `path` can't be written. For use before expensive work."""
    unfinished = names(path)[1]
    if not is_stream(path):
        with open(unfinished, "xb"):
            pass
        os.remove(unfinished)


@contextlib.contextmanager
def whole(path):
    """Opens a temporary binary file, which replaces the one at `path` on success."""
    target, unfinished = names(path)
    if is_stdout(path):
        yield sys.stdout.buffer
        sys.stdout.buffer.flush()
        return
    if is_stream(path):
        with open(path, "wb") as file:
            yield file
        return
    try:
        with open(unfinished, "xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.remove(unfinished)
        raise
