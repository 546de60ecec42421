#!/bin/sh
# Renders a scene from a fresh or outdated clone: installs missing packages, builds, makes the
# scenes' assets, and renders.
#
#   sh scenes/render.sh                          scenes/hebe -> out/hebe.exr and out/hebe.png
#   sh scenes/render.sh -D spp=16                the same, with options for the program
#   sh scenes/render.sh SCENE.xml [OPTION...]    another scene -> out/NAME.exr and out/NAME.png,
#                                                or the output of -o
#
# KINOME_BUILD: build folder; default: build.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
build=${KINOME_BUILD:-$root/build}
. "$root/scenes/setup.sh"

# Parses the arguments like the program, to find out if they contain a scene and an output.
scene=
output=
listing=
[ "${1:-}" = plugins ] && listing=yes
is_value=
for argument in "$@"; do
  if [ -n "$is_value" ]; then
    is_value=
    continue
  fi
  case $argument in
    -o | --output) output=yes is_value=yes ;;
    -o?* | --output=*) output=yes ;;
    -D | --define | -t | --threads | -s | --sensor | -a | --append | --seed | -m | --mode | \
      --exposure | --plugin-path | --inspect | --time | --error | --checkpoint | --every | \
      --display | --isa | --mpi | --part)
      is_value=yes
      ;;
    -h | --help | --version) listing=yes ;;
    -*) ;;
    *) scene=$argument ;;
  esac
done

kinome_install_packages
kinome_configure
ninja -C "$build" kinome_renderer
if [ -n "$listing" ]; then
  exec "$build/bin/kinome" "$@"
fi
# Makes only assets that are missing or outdated.
"$kinome_python" "$root/scenes/make_assets.py"
if [ -z "$scene" ]; then
  scene=$root/scenes/hebe/scene.xml
  set -- "$scene" "$@"
fi
if [ -z "$output" ]; then
  name=$(basename "$scene" .xml)
  [ "$name" != scene ] || name=$(basename "$(CDPATH='' cd -- "$(dirname -- "$scene")" && pwd)")
  mkdir -p "$root/out"
  set -- "$@" -o "$root/out/$name.exr" --png
fi
exec "$build/bin/kinome" "$@"
