#!/bin/sh
# Builds the site of these pages, with one page and picture for each plugin, into build/docs/site:
#
#   sh docs/build.sh [MKDOCS OPTION...]
#
# Takes some minutes, most of them for the pictures. Installs what is missing: Debian's packages, and
# MkDocs in a virtual environment in the build folder. A dead link or a picture that can't be rendered
# ends it.
#
# KINOME_BUILD: build folder; default: build. KINOME_MKDOCS: an mkdocs that is there already.
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
# With -q, MkDocs would count no warnings, and --strict let dead links pass.
NO_MKDOCS_2_WARNING=1 "$mkdocs" build --strict --clean -f "$folder/mkdocs.yml" "$@"
echo "wrote $folder/site/index.html"
