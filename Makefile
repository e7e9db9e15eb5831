# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
#
#   make demo      calibrate a simulated robot cell from its images; results in out/demo
#   make test      C++ and Python tests
#   make lint      formatting, ruff, mypy, generated stubs
#   make gallery   the pictures of doc/gallery.md
#   make bench     the benchmarks behind the tables of the README
#   make sanitize  C++ tests under AddressSanitizer and UndefinedBehaviorSanitizer
#   make fuzz      detectStripe under the sanitizers, and what reads a robot's bytes, with random input, FUZZ_SECONDS (60) each
#   make docs      the site of the documentation in build/docs; warnings and dead links are errors
#   make test-viz  the tests of `calibrate --rerun`, which need a viewer of 170 MB
#   make ur-sample the C++ sample for UR arms: builds ur_rtde from its source package, and runs the sample against the emulator
#   make opencv4, make opencv5   the module inside OpenCV: builds it there, runs all of its tests (half an hour the first time)
#   make wheel     the source package and a wheel for each of PYTHONS (python3 of .venv), tried in bare environments; in build/wheel
#   make clang     the C++ tests built with clang++, warnings are errors
#   make tidy      clang-tidy over the library and the bindings
#   make setup     only what these have in common: system packages, virtual environment, build
# Everything goes into .venv, build and out. A second run builds only what changed and fetches nothing.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
BUILD := build/python
JOBS ?= $(shell nproc)
FUZZ_SECONDS ?= 60
PYTHONS ?= $(BIN)/python
# Python compiles what is imported when it is imported: most of what is installed never is.
PIP_INSTALL = $(BIN)/python -m pip install --quiet --no-compile
# A quarter of the time the tests wait for emulated robots.
TEST_WORKERS ?= $(shell expr $(JOBS) + \( $(JOBS) + 1 \) / 2)

export PATH := $(CURDIR)/$(BIN):$(PATH)
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PIP_RETRIES ?= 8
export PIP_DEFAULT_TIMEOUT ?= 60
export CMAKE_BUILD_PARALLEL_LEVEL ?= $(JOBS)

CMAKE_FILES := CMakeLists.txt $(shell find cmake modules python/bindings -name CMakeLists.txt -o -name '*.cmake' -o -name '*.map')
CPP_FILES := $(shell find modules/active_handeye/include modules/active_handeye/src python/bindings -name '*.[ch]pp')

UR_RTDE := ur_rtde-1.6.5

.PHONY: setup demo test test-cpp test-python test-viz lint format stubs bench sanitize fuzz docs gallery ur-sample opencv4 opencv5 wheel clang \
  tidy clean distclean system-packages
.DELETE_ON_ERROR:

setup: $(VENV)/.requirements $(VENV)/.installed

system-packages:
	@scripts/system-packages $(PYTHON)

$(BIN)/python: | system-packages
	@echo "Making the virtual environment $(VENV)"
	@$(PYTHON) -m venv $(VENV)

# What the build needs comes first, so that `make --jobs=2` compiles while the rest is fetched.
$(VENV)/.build: pyproject.toml scripts/requirements.py | $(BIN)/python
	@$(BIN)/python scripts/requirements.py build >$@.txt
	@$(PIP_INSTALL) --requirement $@.txt
	@touch $@

$(VENV)/.requirements: $(VENV)/.build
	@echo "Installing Python packages into $(VENV)"
	@$(BIN)/python scripts/requirements.py dev >$@.txt
	@$(PIP_INSTALL) --use-pep517 --requirement $@.txt
	@touch $@

$(VENV)/.installed: $(VENV)/.build $(CMAKE_FILES) $(CPP_FILES)
	@echo "Building the C++ module and its Python extension (some minutes the first time)"
	@$(PIP_INSTALL) --no-build-isolation --no-deps --editable .
	@touch $@

demo: setup
	$(BIN)/cv-active-handeye demo --output out/demo

test: test-cpp test-python

test-cpp: setup
	-@scripts/system-packages $(PYTHON) test
	@cmake -S . -B $(BUILD) -DACTIVE_HANDEYE_BUILD_TESTS=ON -DACTIVE_HANDEYE_BUILD_SAMPLES=ON >$(BUILD)/configure.log || { cat $(BUILD)/configure.log; exit 1; }
	@cmake --build $(BUILD) --target tests
	ctest --test-dir $(BUILD) --parallel $(JOBS) --output-on-failure

test-python: test-cpp
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n $(TEST_WORKERS) --dist loadfile --no-loadscope-reorder

test-viz: setup $(VENV)/.viz
	$(BIN)/python -m pytest test/unit/test_report_rerun.py

lint: setup
	git ls-files -z '*.cpp' '*.hpp' | xargs -0 $(BIN)/clang-format --dry-run -Werror
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/python scripts/stubs.py --check

format: setup
	git ls-files -z '*.cpp' '*.hpp' | xargs -0 $(BIN)/clang-format -i
	$(BIN)/ruff check --fix .

stubs: setup
	$(BIN)/python scripts/stubs.py

bench: setup
	-@scripts/system-packages $(PYTHON) bench
	$(BIN)/python -m benchmark --write

gallery: setup
	$(BIN)/python samples/python/08_gallery.py out/gallery --write

sanitize: setup
	@cmake --preset asan-ubsan >/dev/null
	@cmake --build --preset asan-ubsan
	@ctest --preset asan-ubsan --parallel $(JOBS)

fuzz: setup $(VENV)/.fuzz
	@cmake --preset asan-ubsan -DACTIVE_HANDEYE_BUILD_FUZZERS=ON >/dev/null
	@cmake --build build/asan-ubsan --target active_handeye_fuzz_detect_stripe
	cd build/asan-ubsan && bin/active_handeye_fuzz_detect_stripe -max_total_time=$(FUZZ_SECONDS)
	for target in fuzz/fuzz_*.py; do $(BIN)/python $$target -max_total_time=$(FUZZ_SECONDS) -verbosity=0 || exit 1; done

$(VENV)/.docs: pyproject.toml | setup
	@scripts/system-packages $(PYTHON) docs
	@$(BIN)/python scripts/requirements.py docs >$@.txt
	@$(PIP_INSTALL) --requirement $@.txt
	@touch $@

docs: setup $(VENV)/.docs
	@mkdir -p build/doxygen
	doxygen doc/site/Doxyfile
	$(BIN)/python -m sphinx -W --keep-going -n -q -j $(JOBS) -c doc/site . build/docs
	$(BIN)/python doc/site/check_links.py build/docs

build/ur_rtde/.installed: | setup
	@scripts/system-packages $(PYTHON) ur-sample
	@echo "Building $(UR_RTDE) (some minutes)"
	@$(BIN)/python -m pip download --quiet --no-deps --no-binary ur_rtde --dest build/ur_rtde $(subst -,==,$(UR_RTDE))
	@tar -xzf build/ur_rtde/$(UR_RTDE).tar.gz -C build/ur_rtde
	@cmake -S build/ur_rtde/$(UR_RTDE) -B build/ur_rtde/build -DCMAKE_BUILD_TYPE=Release -DPYTHON_BINDINGS=OFF -DBUILD_STATIC=ON \
	  -DEXAMPLES=OFF -DCMAKE_INSTALL_PREFIX=$(CURDIR)/build/ur_rtde/install >build/ur_rtde/build.log
	@nice -n 10 cmake --build build/ur_rtde/build --target install >>build/ur_rtde/build.log
	@touch $@

ur-sample: build/ur_rtde/.installed
	@cmake -S . -B build/ur_sample -DACTIVE_HANDEYE_BUILD_SAMPLES=ON -DCMAKE_PREFIX_PATH=$(CURDIR)/build/ur_rtde/install >/dev/null
	@cmake --build build/ur_sample --target ur_live
	$(BIN)/python -m pytest test/e2e/test_ur_sample.py

$(VENV)/.%: pyproject.toml scripts/requirements.py | setup
	@$(BIN)/python scripts/requirements.py $* >$@.txt
	@$(PIP_INSTALL) --requirement $@.txt
	@touch $@

wheel: setup $(VENV)/.wheel
	$(BIN)/python scripts/build_wheels.py $(PYTHONS)
	$(BIN)/python -m benchmark.wheel --output build/wheel/report.json --write

clang: setup
	@scripts/system-packages $(PYTHON) clang
	@cmake --preset clang >/dev/null
	@cmake --build --preset clang
	@ctest --preset clang --parallel $(JOBS)

tidy: setup $(VENV)/.tidy
	@cmake --preset tidy -Dpybind11_DIR="$$($(BIN)/python -m pybind11 --cmakedir)" >/dev/null
	$(BIN)/run-clang-tidy.py -quiet -p build/tidy -j $(JOBS) 'modules/active_handeye/src/|python/bindings/'

opencv4 opencv5: opencv%: setup
	$(BIN)/python scripts/opencv_in_tree.py $* $(IN_TREE_OPTIONS)

clean:
	rm -rf build out .mypy_cache .ruff_cache .pytest_cache $(VENV)/.installed

distclean: clean
	rm -rf $(VENV)
