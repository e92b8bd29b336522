#!/bin/sh
# A picture of a recording as the Rerun viewer shows it, without a screen or a graphics card:
#
#     picture.sh RUN.rrd OUT.png [WIDTHxHEIGHT]
#
# Also shows a .mcap. Needs a virtual screen and a software renderer, on Debian
#     apt-get install -y --no-install-recommends xvfb xauth mesa-vulkan-drivers libvulkan1 libgl1-mesa-dri \
#         libegl1 libxkbcommon-x11-0 libxcb-xkb1
# and the package rerun-sdk of requirements.txt; RERUN names the program (default: rerun). The picture has
# twice the width and height that are given.
set -eu
rerun=${RERUN:-rerun}
file=${1:?usage: picture.sh RUN.rrd OUT.png [WIDTHxHEIGHT]}
picture=${2:?usage: picture.sh RUN.rrd OUT.png [WIDTHxHEIGHT]}
size=${3:-1600x1000}
driver=${VK_ICD_FILENAMES:-/usr/share/vulkan/icd.d/lvp_icd.$(uname -m).json}

"$rerun" analytics disable >/dev/null 2>&1 || true
rm -f "$picture"
VK_ICD_FILENAMES=$driver LIBGL_ALWAYS_SOFTWARE=1 \
    xvfb-run -a -s "-screen 0 ${size}x24" \
    "$rerun" "$file" --port auto --window-size "$size" --screenshot-to "$picture"
[ -s "$picture" ] || { echo "$picture: the viewer wrote no picture" >&2; exit 1; }
