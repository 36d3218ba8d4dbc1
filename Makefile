# `make demo` and `make test` are all that a fresh Debian 12 needs; everything else is for developers.
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)
BUILD := build
PACKAGES := $(shell cat packages.txt)

.PHONY: demo test test-conformance setup build debug-test gallery format tidy clean

setup:
	@dpkg-query -W -f='$${Status}\n' $(PACKAGES) 2>/dev/null | grep -c '^install ok installed$$' | \
	  grep -qx $(words $(PACKAGES)) || { $(SUDO) apt-get update && \
	  DEBIAN_FRONTEND=noninteractive $(SUDO) apt-get install -y --no-install-recommends $(PACKAGES); }

build: setup
	cmake --preset release
	cmake --build --preset release

demo: build
	$(BUILD)/metrolux render scenes/water-sds/scene.xml --time 60s -o demo.exr -o demo.png

test: build
	ctest --preset release -j 2

# Mitsuba's own render tests, of ../shared/conformance.
test-conformance: build
	ctest --preset release -L conformance

debug-test: setup
	cmake --preset debug
	cmake --build --preset debug
	ctest --preset debug

gallery: build
	tools/gallery.sh

format:
	git ls-files '*.cpp' '*.h' | xargs clang-format -i

tidy: build
	git ls-files 'src/*.cpp' | xargs clang-tidy -p $(BUILD) --quiet

clean:
	rm -rf build build-*
