"""Files that are written in full or not at all."""
import contextlib
import errno
import os


def is_stream(path):
    """A pipe or a device, as /dev/stdout: nothing may take its place."""
    return os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path)


def names(path):
    """(the file that `path` or a link there stands for, the name it has until it is whole).
    Raises OSError where the file can't be written whatever its folder allows."""
    target = os.path.realpath(path)
    if os.path.isdir(target) or not os.path.basename(path):
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
    # The folder alone decides what may be replaced; a file that is read-only is so for a reason.
    if os.path.exists(path) and not os.access(path, os.W_OK):
        raise OSError(errno.EACCES, os.strerror(errno.EACCES))
    return target, f"{target}.{os.getpid()}.part"


def check(path):
    """Raises OSError if nothing can be written there, before much work is done for it."""
    unfinished = names(path)[1]
    if not is_stream(path):
        with open(unfinished, "wb"):
            pass
        os.remove(unfinished)


@contextlib.contextmanager
def whole(path):
    """A binary file to write to, which replaces the one at `path` if all goes well."""
    target, unfinished = names(path)
    if is_stream(path):
        with open(path, "wb") as file:
            yield file
        return
    try:
        with open(unfinished, "wb") as file:
            yield file
        os.replace(unfinished, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.remove(unfinished)
        raise
