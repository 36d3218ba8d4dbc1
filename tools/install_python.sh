#!/usr/bin/env bash
# Installs the Python package of a build where the active virtual environment, or else the Python that it was built for, finds it.
# usage: tools/install_python.sh BUILD
set -euo pipefail
[ $# = 1 ] || { sed -n '3s/^# //p' "$0" >&2; exit 2; }
python=$(sed -n 's/^_Python3_EXECUTABLE:[^=]*=//p' "$1/CMakeCache.txt")
[ -z "${VIRTUAL_ENV:-}" ] || python=$VIRTUAL_ENV/bin/python3
folder=$("$python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')
sudo=
[ -w "$folder" ] || [ "$(id -u)" = 0 ] || sudo=sudo
$sudo cmake --install "$1" --component python --prefix "$folder" >/dev/null
cd /
"$python" -c 'import metrolux; print("metrolux", metrolux.__version__, "is in", metrolux.__path__[0])'
