#!/bin/sh
# Measures the project's performance goals, and writes validation/numbers/.
#
#   sh validation/measure.sh [--mitsuba PYTHON] [--runs N]
#
# --mitsuba: a Python with the package `mitsuba` (3.9.1), for the comparison with scalar_rgb.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
build=${KINOME_BUILD:-$root/build}
. "$root/scenes/setup.sh"
kinome_install_packages
kinome_configure
cmake -S "$root" -B "$build" -DKINOME_BUILD_BENCHMARKS=ON >/dev/null
ninja -C "$build" kinome_renderer kinome_benchmark
"$kinome_python" "$root/scenes/make_assets.py"
exec "$kinome_python" "$root/validation/measure.py" --build "$build" "$@"
