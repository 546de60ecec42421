#!/bin/sh
# Renders one image by several processes, on this machine or on machines listed for GNU parallel:
#
#     scenes/farm/parts.sh SCENE.xml COUNT FOLDER [OPTION...]
#     PARALLEL="--sshloginfile nodes" scenes/farm/parts.sh /shared/scene.xml 64 /shared/out
#
# The script renders COUNT parts into FOLDER, $JOBS at a time (default: 2), and merges them to
# FOLDER/picture.exr. It skips existing parts, even if the options have changed, and continues
# interrupted ones. Without GNU parallel it uses xargs, on this machine only. Set KINOME to the path
# of the program if it isn't on the PATH.
set -eu
[ $# -ge 3 ] || { echo "$0 SCENE.xml COUNT FOLDER [OPTION...]" >&2; exit 1; }
scene=$1
count=$2
folder=$3
shift 3
: "${KINOME:=kinome}" "${JOBS:=2}"
mkdir -p "$folder"

# Prints the numbers of missing parts. A part is incomplete as long as its checkpoint exists.
missing() {
  for i in $(seq "$count"); do
    [ -e "$folder/part-${i}of$count.exr" ] && [ ! -e "$folder/part-${i}of$count.checkpoint" ] || echo "$i"
  done
}
set -- "$KINOME" -q "$scene" --mpi off --part "{}/$count" -o "$folder/part-{}of$count.exr" \
  --checkpoint "$folder/part-{}of$count.checkpoint" --resume "$@"
there=$((count - $(missing | wc -l)))
[ "$there" -eq 0 ] || echo "$0: $folder already contains $there of $count parts"
if command -v parallel >/dev/null 2>&1; then
  missing | parallel --will-cite --quote --halt soon,fail=1 --jobs "$JOBS" "$@"
else
  missing | xargs -P "$JOBS" -I "{}" "$@"
fi
"$KINOME" merge "$folder"/part-*of"$count".exr -o "$folder/picture.exr"
