"""Packages that Debian hasn't got."""
import sys


def use_packages(build):
    """flip_evaluator comes from the virtual environment that validation/run.sh makes in the build
    folder, after Debian's own packages."""
    for found in (build / "validation/mitsuba/lib").glob("python*/site-packages"):
        if str(found) not in sys.path:
            sys.path.append(str(found))
