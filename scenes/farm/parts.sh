#!/bin/sh
# One picture by several programs at once, on this machine or on those that GNU parallel is told of:
#
#     scenes/farm/parts.sh SCENE.xml COUNT FOLDER [OPTION...]
#     PARALLEL="--sshloginfile nodes" scenes/farm/parts.sh /shared/scene.xml 64 /shared/out
#
# renders COUNT parts into FOLDER, JOBS of them at a time (2 unless the variable says otherwise), and
# merges them to FOLDER/picture.exr. Parts that are there already are not rendered again, and those that
# were interrupted go on. Without GNU parallel, xargs does the same on this machine alone. KINOME names
# the program if it isn't on the PATH.
set -eu
scene=$1
count=$2
folder=$3
shift 3
: "${KINOME:=kinome}" "${JOBS:=2}"
mkdir -p "$folder"

# A part has its checkpoint beside it as long as it isn't whole.
missing() {
  for i in $(seq "$count"); do
    [ -e "$folder/part-$i.exr" ] && [ ! -e "$folder/part-$i.checkpoint" ] || echo "$i"
  done
}
set -- "$KINOME" -q "$scene" --mpi off --part "{}/$count" -o "$folder/part-{}.exr" \
  --checkpoint "$folder/part-{}.checkpoint" --resume "$@"
if command -v parallel >/dev/null 2>&1; then
  missing | parallel --will-cite --quote --halt soon,fail=1 --jobs "$JOBS" "$@"
else
  missing | xargs -P "$JOBS" -I "{}" "$@"
fi
"$KINOME" merge "$folder"/part-*.exr -o "$folder/picture.exr"
