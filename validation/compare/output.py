"""Files that are written in full or not at all."""
import contextlib
import errno
import os
import secrets
import sys


def is_stdout(path):
    """/dev/stdout, whatever that is: text that is printed later goes to the same file."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(sys.stdout.fileno()))
    except (OSError, ValueError):
        return False


def is_stream(path):
    """A pipe, a device or /dev/stdout: nothing may take its place."""
    return is_stdout(path) or (os.path.exists(path) and not os.path.isfile(path)
                               and not os.path.isdir(path))


def names(path):
    """(the file that `path` or a link there stands for, the name it has until it is whole).
    Raises OSError where the file can't be written whatever its folder allows."""
    target = os.path.realpath(path)
    if os.path.isdir(target) or not os.path.basename(path):
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
    # The folder alone decides what may be replaced; a file that is read-only is so for a reason.
    if os.path.exists(path) and not os.access(path, os.W_OK):
        raise OSError(errno.EACCES, os.strerror(errno.EACCES))
    return target, f"{target}.{secrets.token_hex(8)}.part"


def check(path):
    """Raises OSError if nothing can be written there, before much work is done for it."""
    unfinished = names(path)[1]
    if not is_stream(path):
        with open(unfinished, "xb"):
            pass
        os.remove(unfinished)


@contextlib.contextmanager
def whole(path):
    """A binary file to write to, which replaces the one at `path` if all goes well."""
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
