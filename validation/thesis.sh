#!/bin/sh
# Renders again what chapter 5 of Åkerlund 2008 shows, with this program and its scenes, and writes
# validation/thesis/: a page, its pictures and the raw numbers. About 20 minutes on two cores.
#
#   sh validation/thesis.sh [--quick] [--output FOLDER]
#
# --quick: the same in a small form, which proves that it works and nothing else; unless --output
#          says otherwise it goes to out/thesis.
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
