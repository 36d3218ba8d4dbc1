#!/usr/bin/env bash
# Builds the command and the quick tests in Debian 13 (Embree 4, GCC 14) and runs them there, in a debootstrap of it.
# As root. ../shared is seen where the checkout has one.
# usage: tools/test_trixie.sh ROOT     ROOT: a folder for that system and the build, made if it is not there (4 GB)
# shellcheck disable=SC2016
set -euo pipefail
[ $# -eq 1 ] || { sed -n '4s/^# //p' "$0" >&2; exit 2; }
source=$(cd "$(dirname "$0")/.." && pwd)
root=$1

if [ ! -e "$root/metrolux/installed" ]; then
    [ -e "$root/etc/debian_version" ] || debootstrap --variant=minbase trixie "$root" http://deb.debian.org/debian
    # shellcheck disable=SC2046
    chroot "$root" env DEBIAN_FRONTEND=noninteractive apt-get install -qy --no-install-recommends $(cat "$source/packages.txt")
    mkdir -p "$root"/metrolux/{source,build,shared}
    touch "$root/metrolux/installed"
fi

# Mounts of a namespace of its own end with it.
SOURCE=$source ROOT=$root unshare --mount bash -euo pipefail -c '
    mount -t proc proc "$ROOT/proc"
    mount --rbind /dev "$ROOT/dev"
    mount --bind -o ro "$SOURCE" "$ROOT/metrolux/source"
    [ ! -d "$SOURCE/../shared" ] || mount --bind -o ro "$(realpath "$SOURCE/../shared")" "$ROOT/metrolux/shared"
    exec chroot "$ROOT" env HOME=/root LC_ALL=C.UTF-8 METROLUX_JOBS="${METROLUX_JOBS:-2}" sh -euc "
        cd /metrolux/source
        cmake -S . -B ../build -G Ninja -DCMAKE_BUILD_TYPE=Release -DMETROLUX_UNITY=ON
        cmake --build ../build -j \$METROLUX_JOBS --target metrolux_command quick_tests
        ../build/metrolux --version
        ctest --test-dir ../build -j \$METROLUX_JOBS --output-on-failure -L \"^(unit/.*|oracle|repository)\\\$\""
'
