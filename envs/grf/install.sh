#!/bin/sh
# Install Google Research Football 2.10.2 with its own Python, built from source on Debian 12 or a similar system, in
# about ten minutes on two cores. The target is $REGISTA_GRF_HOME, where Regista finds it; other packages stay unchanged.
#
#     sh envs/grf/install.sh [--packages | --environment]      only the system's packages, or only the rest
set -eu

home=${REGISTA_GRF_HOME:-$HOME/.local/share/regista/grf}
python=${REGISTA_GRF_SYSTEM_PYTHON:-/usr/bin/python3}  # the system's: boost-python is built for that one
part=${1:-all}

packages="build-essential cmake git python3-venv python3-dev
    libgl1-mesa-dev libsdl2-dev libsdl2-image-dev libsdl2-ttf-dev libsdl2-gfx-dev libdirectfb-dev libst-dev
    libboost-dev libboost-python-dev libboost-thread-dev libboost-filesystem-dev libboost-system-dev"

if [ "$part" != --environment ]; then
    command -v apt-get >/dev/null || { echo "no apt-get here; install by hand: $packages" >&2; exit 1; }
    missing=$(for each in $packages; do dpkg -s "$each" >/dev/null 2>&1 || echo "$each"; done)
    if [ -n "$missing" ]; then
        root=$([ "$(id -u)" = 0 ] || echo sudo)
        $root apt-get update
        DEBIAN_FRONTEND=noninteractive $root apt-get install -y --no-install-recommends $missing
    fi
fi
[ "$part" = --packages ] && exit 0

"$python" -c 'import sys; sys.exit(not (3, 8) <= sys.version_info < (3, 12))' || {
    echo "gfootball needs the system Python to be 3.8 to 3.11, as in Debian 12; $python is $("$python" --version)" >&2
    exit 1
}
"$python" -m venv "$home"
PATH="$home/bin:$PATH" # the build calls python3 and must find this one
export PATH
pip="$home/bin/pip --quiet --disable-pip-version-check"
$pip install 'pip<24' 'setuptools<66' wheel psutil
$pip install numpy==1.26.4 absl-py 'opencv-python-headless<5' pygame six
$pip install --no-build-isolation gym==0.21.0
$pip install --no-build-isolation --no-deps gfootball==2.10.2

"$home/bin/python" - <<'PYTHON'
import gfootball.env

env = gfootball.env.create_environment("academy_empty_goal_close", representation="simple115v2", render=False)
assert env.reset().shape == (115,)
PYTHON
echo "Google Research Football is in $home"
