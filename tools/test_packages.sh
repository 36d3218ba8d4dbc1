#!/usr/bin/env bash
# Installs the packages of a folder in a fresh Debian, in a chroot that is made in the temporary folder and removed at the end, and
# renders there: with the command, in Python, and as on a processor of 2008.
# Needs root, debootstrap, qemu-user and Debian's packages.
# usage: tools/test_packages.sh FOLDER [SUITE]
set -euo pipefail
[ $# -ge 1 ] || { sed -n '5s/^# //p' "$0" >&2; exit 2; }
packages=$(realpath "$1") suite=${2:-bookworm}
root=$(cd "$(dirname "$0")/.." && pwd)
system=$(mktemp -d)
trap 'rm -rf "$system"' EXIT
step() { echo "== $*"; }
inside() { chroot "$system" env DEBIAN_FRONTEND=noninteractive LC_ALL=C HOME=/root "$@"; }

step "a fresh $suite"
debootstrap --variant=minbase "$suite" "$system" > "$system.log" || { tail "$system.log"; exit 1; }
rm -f "$system.log"
cp /etc/resolv.conf "$system/etc/"
mkdir "$system/packages" "$system/work"
cp "$packages"/*.deb "$system/packages"
cp -r "$root/scenes/water-sds/." "$system/work"

step "packages are installed with what they depend on"
inside sh -c 'apt-get update -qq && apt-get install -qqy --no-install-recommends /packages/*.deb' > /dev/null
inside sh -c 'ldd /usr/bin/metrolux $(find /usr/lib -name "*metrolux*.so") | grep "not found"' && exit 1

step "the command"
inside metrolux --version
inside sh -c 'cd /work && metrolux render scene.xml --resolution 64x48 --passes 4 --quiet -o a.exr -o a.png'
inside sh -c 'cd /work && metrolux compare a.exr a.exr'
test -s "$system/usr/share/man/man1/metrolux.1" -a -s "$system/usr/share/bash-completion/completions/metrolux"

step "the Python package"
inside sh -c 'cd /work && python3 -c "
import metrolux
image = metrolux.load(\"scene.xml\").render(passes=2)
assert image.shape[2] == 3 and image.mean() > 0
print(metrolux.__version__, image.shape)"'

# Without AVX: Nehalem, of 2008. The dynamic linker takes the libraries that are for any processor.
step "an old processor"
qemu=(qemu-x86_64 -cpu Nehalem -L "$system" -E "LD_LIBRARY_PATH=")
"${qemu[@]}" "$system/usr/bin/metrolux" render "$system/work/scene.xml" --resolution 16x12 --passes 1 --threads 1 --quiet \
  -o "$system/work/old.exr"
test -s "$system/work/old.exr"
echo "all of it works"
