# `make demo` and `make test` are all that a fresh Debian 12 needs; everything else is for developers.
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)
BUILD := build
PACKAGES := $(shell cat packages.txt)

.PHONY: demo test test-conformance soak-checkpoint setup setup-browser build viewer debug-test gallery format tidy clean

setup:
	@dpkg-query -W -f='$${Status}\n' $(PACKAGES) 2>/dev/null | grep -c '^install ok installed$$' | \
	  grep -qx $(words $(PACKAGES)) || { $(SUDO) apt-get update && \
	  DEBIAN_FRONTEND=noninteractive $(SUDO) apt-get install -y --no-install-recommends $(PACKAGES); }

# npm bundles the page of `metrolux study`. Node from elsewhere brings its own npm, with which Debian's conflicts.
	@command -v npm >/dev/null || { $(SUDO) apt-get update && \
	  DEBIAN_FRONTEND=noninteractive $(SUDO) apt-get install -y --no-install-recommends nodejs npm ca-certificates; } || \
	  echo "without npm: metrolux study will write no page"

# For the test of that page.
setup-browser:
	@command -v chromium >/dev/null || { $(SUDO) apt-get update && \
	  DEBIAN_FRONTEND=noninteractive $(SUDO) apt-get install -y --no-install-recommends chromium; } || \
	  echo "without chromium: the test of the page of metrolux study is skipped"

build: setup
	cmake --preset release
	cmake --build --preset release

demo: build
	$(BUILD)/metrolux render scenes/water-sds/scene.xml --time 60s -o demo.exr -o demo.png

# Bundles the page again, for example when the registry of npm could not be reached before.
viewer: setup
	cmake --preset release
	rm -f $(BUILD)/web/page_template.cpp
	cmake --build --preset release --target metrolux_command

test: build setup-browser
	ctest --preset release -j 2

# Mitsuba's own render tests, of ../shared/conformance.
test-conformance: build
	ctest --preset release -L conformance

# Each integrator killed ten times and resumed.
soak-checkpoint: build
	cmake --build --preset release --target test_cli
	METROLUX_KILLS=10 $(BUILD)/tests/test_cli --gtest_filter='*KillTest*'

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
