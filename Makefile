# `make demo` and `make test` are all that a fresh Debian 12 needs; everything else is for developers.
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)
BUILD := build
PACKAGES := $(shell cat packages.txt)

.PHONY: demo test test-conformance setup setup-browser build viewer debug-test gallery study format tidy clean integrator-pictures sanitize thread-test fuzz soak bench soak-checkpoint

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

# Kernels and whole renders; results in build/bench/results. SCENES=... for other scenes, QUICK=1 for small sizes.
bench: setup
	cmake --preset release -DMETROLUX_BENCH=ON
	cmake --build --preset release --target metrolux_command bench_kernels bench_scene
	bench/run.sh $(BUILD)

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

# The unit tests under the thread sanitizer, but for those of a single chain, which one thread runs for minutes there.
SERIAL_TESTS := Chain\.|Unbiased|Ragged
thread-test: setup
	cmake --preset thread
	cmake --build --preset thread
	ctest --preset thread -L '^unit/' -E '$(SERIAL_TESTS)'

# All tests with the address and undefined-behavior sanitizers, and a part of them with the thread sanitizer.
sanitize: debug-test thread-test

# libFuzzer on each parser, FUZZ_SECONDS each (needs clang).
FUZZ_SECONDS := 300
FUZZ_TARGETS := obj ply serialized spectrum image scene checkpoint
fuzz: setup
	cmake --preset fuzz
	cmake --build --preset fuzz --target $(FUZZ_TARGETS:%=fuzz_%)
	for target in $(FUZZ_TARGETS); do fuzz/run.sh $(FUZZ_BUILD) $$target $(FUZZ_SECONDS) || exit 1; done
FUZZ_BUILD := build-fuzz

# Random scenes through all integrators with the address and undefined-behavior sanitizers.
SOAK_SECONDS := 1800
soak: setup
	cmake --preset debug
	cmake --build --preset debug --target metrolux_soak
	nice -n 10 build-debug/tools/soak/metrolux_soak --seconds $(SOAK_SECONDS) --report soak.json

gallery: build
	tools/gallery.sh

# All integrators on six hard scenes, a minute of processor time each, as web pages in study/: more than an hour.
study: build
	tools/study.sh study
	tools/study_table.py study

# The pictures of docs/reference/integrators.md: two minutes of processor time.
integrator-pictures: build
	tools/integrator_pictures.sh

format:
	git ls-files '*.cpp' '*.h' | xargs clang-format -i

tidy: build
	git ls-files 'src/*.cpp' | xargs clang-tidy -p $(BUILD) --quiet

clean:
	rm -rf build build-*
