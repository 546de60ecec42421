#!/bin/sh
# Renders a scene, from whatever state the clone is in: installs what is missing, builds, makes the
# scenes' assets, renders.
#
#   sh scenes/render.sh                          scenes/hebe -> out/hebe.exr and out/hebe.png
#   sh scenes/render.sh -D spp=16                the same, with options for the program
#   sh scenes/render.sh SCENE.xml [OPTION...]    another scene -> out/NAME.exr and out/NAME.png,
#                                                unless -o says otherwise
#
# KINOME_BUILD: build folder; default: build.
set -eu
root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd)
build=${KINOME_BUILD:-$root/build}
. "$root/scenes/setup.sh"

# Reads the arguments as the program will: is a scene among them, and a place for the picture?
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
# Knows itself what is up to date.
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
