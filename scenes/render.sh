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

build_program() {
  kinome_configure
  # Silent where nothing is to be done.
  ninja -C "$build" --quiet kinome_renderer
}

# Assets are made anew when the scripts that make them change, or when one is gone.
make_assets() {
  stamp=$root/scenes/.assets
  recipe=$(find "$root/scenes" -name '*.py' -exec cksum {} + | sort | cksum)
  made=$(find "$root"/scenes/*/assets -type f 2>/dev/null | sort | cksum)
  [ -f "$stamp" ] && [ "$(cat "$stamp")" = "$recipe $made" ] && return 0
  rm -f "$stamp"
  python3 "$root/scenes/make_assets.py"
  made=$(find "$root"/scenes/*/assets -type f | sort | cksum)
  printf '%s %s\n' "$recipe" "$made" >"$stamp"
}

# Reads the arguments as the program will: which is the scene, and what is set already?
scene=
output=
integrator=
listing=
[ "${1:-}" = plugins ] && listing=yes
option=
for argument in "$@"; do
  case $option in
    '') ;;
    -D | --define)
      case $argument in integrator=*) integrator=yes ;; esac
      option=
      continue
      ;;
    *)
      option=
      continue
      ;;
  esac
  case $argument in
    -o | --output)
      output=yes
      option=$argument
      ;;
    -o?* | --output=*) output=yes ;;
    -Dintegrator=* | --define=integrator=*) integrator=yes ;;
    -D | --define | -t | --threads | -s | --sensor | -a | --append | --seed | -m | --mode | \
      --exposure | --plugin-path)
      option=$argument
      ;;
    -h | --help | --version) listing=yes ;;
    -*) ;;
    *) scene=$argument ;;
  esac
done

kinome_install_packages
build_program
if [ -n "$listing" ]; then
  exec "$build/bin/kinome" "$@"
fi
make_assets
if [ -z "$scene" ]; then
  scene=$root/scenes/hebe/scene.xml
  [ -n "$integrator" ] || set -- -D integrator=clustered "$@"
  set -- "$scene" "$@"
fi
if [ -z "$output" ]; then
  name=$(basename "$scene" .xml)
  [ "$name" != scene ] || name=$(basename "$(CDPATH='' cd -- "$(dirname -- "$scene")" && pwd)")
  mkdir -p "$root/out"
  set -- "$@" -o "$root/out/$name.exr" --png
fi
exec "$build/bin/kinome" "$@"
