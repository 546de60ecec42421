"""Python packages that aren't part of Debian."""
import sys


def use_packages(build):
    """Adds the packages of the virtual environment of validation/run.sh in the build folder, for
    flip_evaluator. Debian's packages take precedence."""
    for found in (build / "validation/mitsuba/lib").glob("python*/site-packages"):
        if str(found) not in sys.path:
            sys.path.append(str(found))
