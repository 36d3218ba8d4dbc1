#!/usr/bin/env bash
# Runs tests/blender with the Blender of Debian 13 (4.3), in a debootstrap of it, with the command of a build for this system.
# usage: tools/blender_trixie.sh BUILD ROOT [MODULE...]     ROOT: a folder for the other system, made if it is not there (3 GB)
set -euo pipefail
[ $# -ge 2 ] || { sed -n '3s/^# //p' "$0" >&2; exit 2; }
source=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "$1" && pwd)
root=$2
shift 2
[ $# -gt 0 ] || set -- engine cameras lights materials

if [ ! -x "$root/usr/bin/blender" ]; then
    debootstrap --variant=minbase trixie "$root" http://deb.debian.org/debian
    chroot "$root" apt-get install -y --no-install-recommends blender python3-numpy
fi
# The command runs there with the libraries of this system.
mkdir -p "$root"/metrolux/{source,lib,scripts}
cp -r "$source"/{blender,tests,tools,docs} "$root/metrolux/source/"
cp "$build/metrolux-blender.zip" "$root/metrolux/"
cp "$build/metrolux" "$root/metrolux/lib/metrolux"
ldd "$build/metrolux" | awk '/=> \//{print $3}' | xargs -I{} cp -L {} "$root/metrolux/lib/"
cp -L /lib64/ld-linux-x86-64.so.2 "$root/metrolux/lib/loader"
cat > "$root/metrolux/metrolux" <<'END'
#!/bin/sh
exec /metrolux/lib/loader --library-path /metrolux/lib /metrolux/lib/metrolux "$@"
END
chmod +x "$root/metrolux/metrolux"

status=0
for module; do
    # Mounts of a namespace of its own end with it.
    unshare --mount sh -c 'mount -t proc proc "$0/proc" && mount --rbind /dev "$0/dev" && exec chroot "$0" "$@"' "$root" \
        env HOME=/tmp METROLUX_COMMAND=/metrolux/metrolux METROLUX_ADDON=/metrolux/metrolux-blender.zip \
        BLENDER_USER_SCRIPTS=/metrolux/scripts BLENDER_USER_CONFIG=/metrolux/scripts \
        blender -b --factory-startup --python-exit-code 1 -P /metrolux/source/tests/blender/run.py -- "test_$module" || status=1
done
exit $status
