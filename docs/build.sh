#!/bin/sh
# Builds the documentation site, with a page and an image for each plugin, in build/docs/site:
#
#   sh docs/build.sh [MKDOCS OPTION...]
#
# Takes some minutes for the first time, most of them for the images, which are kept for the next one.
# Installs missing Debian packages, and MkDocs in a
# virtual environment in the build folder. Dead links and failed renders are errors.
#
# KINOME_BUILD: build folder; default: build. KINOME_MKDOCS: path of an installed mkdocs.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
build=${KINOME_BUILD:-$root/build}
. "$root/scenes/setup.sh"

kinome_packages="$kinome_packages $kinome_report_packages python3-venv"
kinome_install_packages
kinome_configure
ninja -C "$build" kinome_renderer

folder=$build/docs
mkdir -p "$folder"
mkdocs=${KINOME_MKDOCS:-$folder/venv/bin/mkdocs}
if [ -z "${KINOME_MKDOCS:-}" ] && ! cmp -s "$root/docs/requirements.txt" "$folder/venv/requirements.txt"; then
  rm -rf "$folder/venv"
  "$kinome_python" -m venv "$folder/venv"
  "$folder/venv/bin/pip" install -q -r "$root/docs/requirements.txt"
  cp "$root/docs/requirements.txt" "$folder/venv/requirements.txt"
fi
"$kinome_python" "$root/docs/site/collect.py" "$build" "$folder"
# Don't use -q: MkDocs then counts no warnings, so that --strict accepts dead links.
NO_MKDOCS_2_WARNING=1 "$mkdocs" build --strict --clean -f "$folder/mkdocs.yml" "$@"
echo "wrote $folder/site/index.html"
