#!/bin/sh
# Checks a Rerun file with the viewer's own tools, which are a later version than the one that wrote it:
#
#     check_rrd.sh RUN.rrd [SAME_RUN_AGAIN.rrd]
#
# It must be complete and understood, hold the entities that the layout shows, and, given a second file of the
# same run, be equal to it but for the random numbers of rows. RERUN names the program (default: rerun, from
# requirements.txt). The exit code is 0 only when all of this holds.
set -eu
rerun=${RERUN:-rerun}
file=${1:?usage: check_rrd.sh RUN.rrd [SAME_RUN_AGAIN.rrd]}

"$rerun" rrd verify "$file"

entities=$("$rerun" rrd print "$file" 2>/dev/null)
for entity in /world /state/phase /state/verdict/ /events /verdict /plot/share/jerk /plot/tracking/tool \
    /joints/position /world/run/tool_path /world/robot/ /world/cell/; do
    case $entities in
        *"$entity"*) ;;
        *) echo "$file: nothing is logged at $entity" >&2; exit 1 ;;
    esac
done

# The only timeline is simulated time: no wall clock reaches a recording.
case $entities in
    *log_time*|*log_tick*) echo "$file: it holds a timeline of the wall clock" >&2; exit 1 ;;
esac

if [ $# -gt 1 ]; then
    "$rerun" rrd compare --unordered "$file" "$2"
fi
echo "$file: complete, understood, with all entities that the layout shows"
