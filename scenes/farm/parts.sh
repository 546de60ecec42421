#!/bin/sh
# One picture by several programs at once, on this machine or on those that GNU parallel is told of:
#
#     scenes/farm/parts.sh SCENE.xml COUNT FOLDER [OPTION...]
#     PARALLEL="--sshloginfile nodes" scenes/farm/parts.sh /shared/scene.xml 64 /shared/out
#
# renders COUNT parts into FOLDER, JOBS of them at a time (2 unless the variable says otherwise), and
# merges them to FOLDER/picture.exr. Parts that are there already are not rendered again, whatever the
# options are now, and those that were interrupted go on. Without GNU parallel, xargs does the same on this machine alone. KINOME names
# the program if it isn't on the PATH.
set -eu
[ $# -ge 3 ] || { echo "$0 SCENE.xml COUNT FOLDER [OPTION...]" >&2; exit 1; }
scene=$1
count=$2
folder=$3
shift 3
: "${KINOME:=kinome}" "${JOBS:=2}"
mkdir -p "$folder"

# A part has its checkpoint beside it as long as it isn't whole.
missing() {
  for i in $(seq "$count"); do
    [ -e "$folder/part-${i}of$count.exr" ] && [ ! -e "$folder/part-${i}of$count.checkpoint" ] || echo "$i"
  done
}
set -- "$KINOME" -q "$scene" --mpi off --part "{}/$count" -o "$folder/part-{}of$count.exr" \
  --checkpoint "$folder/part-{}of$count.checkpoint" --resume "$@"
there=$((count - $(missing | wc -l)))
[ "$there" -eq 0 ] || echo "$0: $there of $count parts are there already, in $folder"
if command -v parallel >/dev/null 2>&1; then
  missing | parallel --will-cite --quote --halt soon,fail=1 --jobs "$JOBS" "$@"
else
  missing | xargs -P "$JOBS" -I "{}" "$@"
fi
"$KINOME" merge "$folder"/part-*of"$count".exr -o "$folder/picture.exr"
