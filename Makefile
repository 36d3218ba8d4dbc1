# `make demo` and `make test` are all that a fresh Debian needs; `make help` lists the rest, which is for developers.
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)
PACKAGES := $(shell cat packages.txt)
install = { $(SUDO) apt-get update && DEBIAN_FRONTEND=noninteractive $(SUDO) apt-get install -y --no-install-recommends $(1); }
BUILD := build

help:  ## this list
	@sed -nE 's/^([a-z-]+):.*## (.*)/  make \1\t\2/p' Makefile | expand -t 28

demo: setup  ## installs the packages, builds, renders tiles under waves for a minute: demo.png, demo.exr
	cmake --preset demo
	cmake --build --preset demo --target metrolux_command
	$(BUILD)/metrolux render scenes/water-sds/scene.xml --resolution 800x600 --time 60s --denoise -o demo.exr -o demo.png

test: setup-python build setup-browser  ## builds and runs all tests; says which were skipped and why
	tools/run_tests.sh release -j 2

quick: setup  ## builds and runs the unit, oracle and repository tests: under three minutes once built
	cmake --preset release
	cmake --build --preset release --target quick_tests
	tools/run_tests.sh release -j 2 -L '^(unit/.*|oracle|repository)$$'

build: setup setup-page  ## builds everything
	cmake --preset release
	cmake --build --preset release

setup:
	@dpkg-query -W -f='$${Status}\n' $(PACKAGES) 2>/dev/null | grep -c '^install ok installed$$' | \
	  grep -qx $(words $(PACKAGES)) || $(call install,$(PACKAGES))

# npm bundles the page of `metrolux study` for its test. Node from elsewhere brings its own npm, with which Debian's conflicts.
setup-page:
	@command -v npm >/dev/null || $(call install,nodejs npm ca-certificates) || \
	  echo "without npm: the page of metrolux study is not tested"

# For the tests of that page and of the page of metrolux view.
setup-browser:
	@command -v chromium >/dev/null || $(call install,chromium) || \
	  echo "without chromium: the tests of the pages of metrolux study and view are skipped"

# For the Python package, which is built where they are.
PYTHON_PACKAGES := $(shell cat python/packages.txt)
setup-python:
	@dpkg-query -W -f='$${Status}\n' $(PYTHON_PACKAGES) 2>/dev/null | grep -c '^install ok installed$$' | \
	  grep -qx $(words $(PYTHON_PACKAGES)) || $(call install,$(PYTHON_PACKAGES)) || \
	  echo "without $(PYTHON_PACKAGES): the Python package is not built, and its tests are skipped"

python: setup setup-python  ## the Python package, into the active virtual environment, or else for all Pythons of the system
	cmake --preset release -DMETROLUX_PYTHON=ON
	cmake --build --preset release --target python_package
	tools/install_python.sh $(BUILD)

blender-addon: setup  ## the Blender add-on, to install from disk: build/metrolux-blender.zip
	cmake --preset release
	cmake --build --preset release --target blender_addon

# Several hundred MB; without it the tests of the add-on are skipped.
setup-blender:  ## installs Blender for the tests of the add-on
	@command -v blender >/dev/null || $(call install,blender)

test-blender: build setup-blender  ## the tests of the Blender add-on
	cmake --preset release
	tools/run_tests.sh release -L blender

# As root; not part of the suite.
test-blender-trixie: build  ## the same with the Blender 4.3 of Debian 13, in a debootstrap of it (3 GB in build-trixie)
	@command -v debootstrap >/dev/null || $(call install,debootstrap)
	$(SUDO) tools/blender_trixie.sh $(BUILD) build-trixie

blender-parameters: build  ## the add-on's parameters of integrators
	tools/blender_parameters.py $(BUILD)/metrolux > blender/metrolux/parameters.json

blender-reference:  ## the tables of docs/reference/blender.md, from the exporter
	blender -b --factory-startup --python-exit-code 1 -P tools/blender_reference.py -- docs/reference/blender.md

blender-pictures: build blender-addon setup-blender  ## the pictures of docs/tutorial/blender.md
	tools/blender_pictures.sh $(BUILD)

# As the packages: for any x86-64, and a second time for processors with AVX2.
PREFIX := /usr/local
install: setup  ## the command, libmetrolux.so, its headers and CMake package, below PREFIX=/usr/local
	cmake --preset package
	cmake --build --preset package --target metrolux_command metrolux_library
	$(SUDO) cmake --install build-package --prefix $(PREFIX)
	$(SUDO) ldconfig

# What is packaged is for any x86-64 and has a second build for processors with AVX2.
packages: setup setup-python  ## Debian packages, in build-package/packages
	cmake --preset package
	cmake --build --preset package
	rm -rf build-package/packages
	cd build-package && cpack

test-packages: packages  ## installs them in a fresh Debian and renders there, also as on a processor of 2008
	@command -v debootstrap >/dev/null && command -v qemu-x86_64 >/dev/null || $(call install,debootstrap qemu-user)
	$(SUDO) tools/test_packages.sh build-package/packages

# As root; not part of the suite.
test-trixie:  ## builds and runs the quick tests in a debootstrap of Debian 13: Embree 4, GCC 14 (4 GB in build-debian13)
	@command -v debootstrap >/dev/null || $(call install,debootstrap)
	$(SUDO) tools/test_trixie.sh build-debian13

viewer: setup setup-page  ## bundles the page of metrolux study, web/viewer.html, from web/src
	cmake --preset release
	cmake --build --preset release --target viewer

bench: setup  ## kernels and whole renders, to build/bench/results; SCENES=... for other scenes, QUICK=1 for small sizes
	cmake --preset release -DMETROLUX_BENCH=ON
	cmake --build --preset release --target metrolux_command bench_kernels bench_scene
	bench/run.sh $(BUILD)

test-conformance: build  ## Mitsuba's own render tests, of ../shared/conformance
	tools/run_tests.sh release -L conformance

soak-checkpoint: build  ## each integrator killed ten times and resumed
	METROLUX_KILLS=10 $(BUILD)/tests/test_cli --gtest_filter='*KillTest*'

debug-test: setup  ## all tests with the address and undefined-behavior sanitizers
	cmake --preset debug
	cmake --build --preset debug
	tools/run_tests.sh debug

# But for tests of a single chain, which one thread runs for minutes under that sanitizer.
SERIAL_TESTS := Chain\.|Unbiased|Ragged
thread-test: setup  ## the unit tests with the thread sanitizer
	cmake --preset thread
	cmake --build --preset thread
	tools/run_tests.sh thread -L '^unit/' -E '$(SERIAL_TESTS)'

sanitize: debug-test thread-test  ## debug-test and thread-test

sanitize-all: debug-test  ## the whole suite with both sanitizers, one after the other: hours (docs/development/testing.md)
	cmake --preset thread
	cmake --build --preset thread
	tools/run_tests.sh thread

FUZZ_SECONDS := 300
FUZZ_TARGETS := obj ply serialized volume spectrum ies gltf pbrt image scene checkpoint
fuzz: setup  ## libFuzzer on each parser, FUZZ_SECONDS each (needs clang)
	cmake --preset fuzz
	cmake --build --preset fuzz --target $(FUZZ_TARGETS:%=fuzz_%)
	for target in $(FUZZ_TARGETS); do fuzz/run.sh build-fuzz $$target $(FUZZ_SECONDS) || exit 1; done

SOAK_SECONDS := 1800
soak: setup  ## random scenes through all integrators with sanitizers, SOAK_SECONDS long
	cmake --preset debug
	cmake --build --preset debug --target metrolux_soak
	nice -n 10 build-debug/tools/soak/metrolux_soak --seconds $(SOAK_SECONDS) --report soak.json

gallery: build setup-python  ## the pictures of the README: an hour on one core
	tools/gallery.sh

study: build  ## all integrators on six hard scenes, as web pages in study/: more than an hour
	tools/study.sh study
	tools/study_table.py study

integrator-pictures: build  ## the pictures of docs/lab/integrators.md
	tools/integrator_pictures.sh

tutorial-pictures: build setup-python  ## the pictures of the tutorials in Python
	tools/tutorial_pictures.sh $(BUILD)

view-picture: build setup-browser  ## the picture of the live view's page
	tools/view_picture.sh $(BUILD)

parameters: build  ## the page of the integrators' parameters, docs/reference/parameters.md
	$(BUILD)/metrolux integrators --markdown > docs/reference/parameters.md

format:  ## clang-format on all sources
	git ls-files '*.cpp' '*.h' | xargs clang-format -i

tidy: build  ## clang-tidy on all sources
	git ls-files 'src/*.cpp' | xargs clang-tidy -p $(BUILD) --quiet

hook:  ## checks format, and tidiness where there is a build, before each commit: tools/pre_commit.sh
	git config core.hooksPath tools/hooks

clean:  ## removes all build folders
	rm -rf build build-*

.PHONY: $(shell sed -nE 's/^([a-z-]+):.*/\1/p' Makefile)
