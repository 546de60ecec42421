#!/bin/sh
# Repeats the experiments of chapter 5 of Åkerlund 2008 with this program and its scenes, and writes
# validation/thesis/: a page, its images and the raw numbers. Takes about 20 minutes on two cores.
#
#   sh validation/thesis.sh [--quick] [--output FOLDER]
#
# --quick: a small form, which only checks that the command works. It writes out/thesis unless
#          --output is given.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
build=${KINOME_BUILD:-$root/build}
. "$root/scenes/setup.sh"
kinome_packages="$kinome_packages $kinome_report_packages"
kinome_install_packages
kinome_configure
ninja -C "$build" kinome_renderer
"$kinome_python" "$root/scenes/make_assets.py"
exec "$kinome_python" "$root/validation/thesis.py" --build "$build" "$@"
