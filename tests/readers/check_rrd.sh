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
holds() {
    case $entities in *"$1"*) true ;; *) false ;; esac
}
needs() {
    for entity; do
        holds "$entity" || { echo "$file: nothing is logged at $entity" >&2; exit 1; }
    done
}
needs /world /events /verdict /state/phase /state/verdict/ /world/plan/
# A run that was only planned has no curves; one that was executed has them all, and a robot that moves.
if holds /joints/ || holds /plot/ || holds /world/run/; then
    needs /joints/position /joints/velocity /joints/effort /world/run/tool_path /world/robot/ \
        /plot/share/velocity /plot/share/acceleration /plot/share/jerk /plot/share/torque /plot/share/limit \
        /plot/tracking/tool /plot/gripper/opening /plot/gripper/force
fi

# The only timeline is simulated time: no wall clock reaches a recording.
if holds log_time || holds log_tick; then
    echo "$file: it holds a timeline of the wall clock" >&2
    exit 1
fi

if [ $# -gt 1 ]; then
    "$rerun" rrd compare --unordered "$file" "$2"
fi
echo "$file: complete, understood, with all entities that the layout shows"
