#!/usr/bin/env bash
# Installs the packages of a folder in a fresh Debian, in a chroot that is made in the temporary folder and removed at the end, and
# renders there: with the command alone, in Python, with a program of libmetrolux-dev, under MPI, and as on a processor of 2008.
# Needs root, debootstrap, qemu-user and Debian's packages.
# usage: tools/test_packages.sh FOLDER [SUITE]
# shellcheck disable=SC2016  # what is quoted is for the shell in the chroot
set -euo pipefail
[ $# -ge 1 ] || { sed -n '5s/^# //p' "$0" >&2; exit 2; }
packages=$(realpath "$1") suite=${2:-bookworm}
root=$(cd "$(dirname "$0")/.." && pwd)
system=$(mktemp -d)
trap 'rm -rf "$system"' EXIT
step() { echo "== $*"; }
fail() { echo "$*" >&2; exit 1; }
# /proc is mounted in a namespace of its own, which ends with the command.
inside() {
    SYSTEM=$system unshare --mount sh -c 'mount -t proc proc "$SYSTEM/proc" && exec chroot "$SYSTEM" "$@"' sh \
        env DEBIAN_FRONTEND=noninteractive LC_ALL=C HOME=/root sh -euc "cd /work; $1"
}
# Others than Debian's are in /packages.
install() { inside "apt-get install -qqy --no-install-recommends $*" > /dev/null; }
# What a program has loaded that the dynamic linker chose for the processor.
levels() { grep -o 'calling init: .*glibc-hwcaps/x86-64-v[0-9]*/libmetrolux[a-z_]*' | sort -u || true; }

step "a fresh $suite"
debootstrap --variant=minbase "$suite" "$system" > "$system.log" || { tail "$system.log"; exit 1; }
rm -f "$system.log"
cp /etc/resolv.conf "$system/etc/"
mkdir "$system/packages" "$system/work"
cp "$packages"/*.deb "$system/packages"
cp -r "$root/scenes/water-sds/." "$root/tests/consumer/consumer.cpp" "$system/work"
inside 'apt-get update -qq'

step "the command, with nothing but its dependencies"
install '/packages/metrolux_*.deb'
inside 'metrolux --version'
inside 'metrolux render scene.xml --resolution 64x48 --passes 4 --quiet -o a.exr -o a.png; metrolux compare a.exr a.exr'
for file in man/man1/metrolux.1 bash-completion/completions/metrolux zsh/vendor-completions/_metrolux \
    fish/vendor_completions.d/metrolux.fish doc/metrolux/copyright; do
    test -s "$system/usr/share/$file" || fail "metrolux_*.deb has no usr/share/$file"
done
inside 'bash -euc "source /usr/share/bash-completion/completions/metrolux; complete -p metrolux"'
if grep -qw avx2 /proc/cpuinfo && [ -z "$(inside 'LD_DEBUG=libs metrolux --version 2>&1' | levels)" ]; then
    fail "the processor has AVX2, and the library for it was not loaded"
fi

step "the Python package"
install '/packages/libmetrolux[0-9]*.deb /packages/python3-metrolux_*.deb'
inside 'python3 -c "
import metrolux
image = metrolux.load(\"scene.xml\").render(passes=2)
assert image.shape[2] == 3 and image.mean() > 0
print(metrolux.__version__, image.shape)"'

step "a program of libmetrolux-dev"
install '/packages/libmetrolux-dev_*.deb g++ pkg-config cmake make'
inside 'g++ -std=c++17 consumer.cpp -o consumer $(pkg-config --cflags --libs metrolux); ./consumer by-pkg-config'
inside 'printf "%s\n" "cmake_minimum_required(VERSION 3.22)" "project(Consumer CXX)" "find_package(Metrolux REQUIRED)" \
    "add_executable(by-cmake consumer.cpp)" "target_link_libraries(by-cmake Metrolux::metrolux)" > CMakeLists.txt
    cmake -B build > /dev/null; cmake --build build > /dev/null; build/by-cmake output'

step "MPI"
install '/packages/metrolux-*.deb openmpi-bin'
inside 'mpirun --allow-run-as-root --oversubscribe -n 2 metrolux render scene.xml --slices 2 --resolution 32x24 --passes 4 --quiet -o mpi.exr
    metrolux render scene.xml --slices 2 --resolution 32x24 --passes 4 --quiet -o one.exr; metrolux compare mpi.exr one.exr'

missing=$(inside 'ldd /usr/bin/metrolux $(find /usr/lib -name "*metrolux*.so*" -type f)' | grep "not found" || true)
[ -z "$missing" ] || fail "$missing"

# Without AVX: Nehalem, of 2008. The dynamic linker takes the libraries that are for any processor.
step "an old processor"
qemu=(qemu-x86_64 -cpu Nehalem -L "$system" -E LD_LIBRARY_PATH= -E LD_DEBUG=libs)
"${qemu[@]}" "$system/usr/bin/metrolux" render "$system/work/scene.xml" --resolution 16x12 --passes 1 --threads 1 --quiet \
  -o "$system/work/old.exr" 2> "$system/log" || { grep -v '^ *[0-9]*:' "$system/log"; exit 1; }
test -s "$system/work/old.exr"
[ -z "$(levels < "$system/log")" ] || fail "the processor has no AVX, and a library for it was loaded: $(levels < "$system/log")"
echo "all of it works"
