# Each target sets up what it needs on a fresh machine: a .venv here; for what draws or computes, a Vulkan driver where
# there is none; for all tests, a browser and a screen. `make PYTHON=python3.13` picks the Python that .venv is made of.

# `make test ADAPTER=swiftshader` picks the adapter by a part of its name, DRIVER_FILE=.../lvp_icd.json the Vulkan driver
# by its JSON file, as of a Mesa that is unpacked beside the installed one; LOCKED=1 installs what requirements/ names.

PYTHON ?= python3
BIN := .venv/bin
# Each worker takes neighbouring tests, which use the same pipelines and compiled loops.
PYTEST := $(BIN)/pytest --numprocesses auto --maxprocesses 4 --dist worksteal
ADAPTER ?=
DRIVER_FILE ?= $(if $(filter swiftshader,$(ADAPTER)),/usr/lib/chromium/vk_swiftshader_icd.json)
LOCKED ?=
# Where it is set, each worker and each process that a test starts would compile all modules again.
export PYTHONDONTWRITEBYTECODE :=
ifneq ($(ADAPTER),)
export GPU_XFORM_ADAPTER := $(ADAPTER)
endif
ifneq ($(DRIVER_FILE),)
export VK_DRIVER_FILES := $(DRIVER_FILE)
endif
DRIVER_PACKAGES := mesa-vulkan-drivers libvulkan1
BROWSER_PACKAGES := chromium-driver
SCREEN_PACKAGES := xvfb xdotool libx11-6

.DEFAULT_GOAL := help

.PHONY: help
help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-10s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

.PHONY: demo
demo: .venv/library driver ## draw four pictures into demo/ and measure a bulk transform
	@$(BIN)/python examples/demo.py

.PHONY: test
test: .venv/tools driver browser screen ## run the whole test suite
	@$(PYTEST)

.PHONY: test-quick
test-quick: .venv/tools driver ## run the tests that need no browser and no screen, but for the slow ones
	@$(PYTEST) -m "not (browser or screen or slow)"

.PHONY: check
check: .venv/tools ## check format, lint and types
	@$(BIN)/ruff format --check .
	@$(BIN)/ruff check .
	@$(BIN)/mypy

.PHONY: bench
bench: .venv/bench driver ## measure side by side with other libraries
	@$(BIN)/python benchmarks/load.py
	@$(BIN)/python benchmarks/surfaces.py
	@$(BIN)/python benchmarks/transform.py
	@$(BIN)/python benchmarks/convolve.py
	@$(BIN)/python benchmarks/render.py
	@$(BIN)/python benchmarks/shading.py
	@$(BIN)/python benchmarks/animate.py
	@$(BIN)/python benchmarks/springs.py
	@$(BIN)/python benchmarks/scale.py --fraction 0.1

SECONDS ?= 300
SHARE ?= 1
MOMENTS ?= 200

.PHONY: fuzz
fuzz: .venv/tools driver ## give damaged files to every reader, and odd arguments to functions, for SECONDS=300 of a processor each
	@$(BIN)/python -m tests.fuzz.readers --seconds $(SECONDS)
	@$(BIN)/python -m tests.fuzz.calls --seconds $(SECONDS)

.PHONY: soak
soak: .venv/tools driver ## do the same for long, and see that nothing grows; SHARE=0.1 a tenth of it
	@$(BIN)/python -m tests.fuzz.soak --share $(SHARE)
	@GPU_XFORM_STABLE_STEPS=1000000 $(PYTEST) tests/simulation/test_acceptance.py -k stay_stable

.PHONY: lock
lock: ## write requirements/, the versions that CI installs with LOCKED=1; needs uv
	@uv pip compile --quiet --universal --python-version 3.11 --extra dev --generate-hashes --no-emit-index-url \
	  --custom-compile-command "make lock" --output-file requirements/ci.txt pyproject.toml

.PHONY: attack
attack: .venv/tools driver ## interrupt and kill commands at MOMENTS=200 random moments, and fill disks under them
	@GPU_XFORM_INTERRUPTIONS=$(MOMENTS) $(PYTEST) tests/gpu/test_interruptions.py
	@$(BIN)/python -m tests.fuzz.attack --moments $(MOMENTS)
	@$(BIN)/python -m tests.fuzz.full_disk --moments $(MOMENTS)

.PHONY: docs
docs: .venv/docs driver ## build the documentation site into build/site/html; warnings and broken links are errors
	@$(BIN)/python -m docs.builder

.PHONY: test-docs
test-docs: .venv/tools docs browser ## build the site, and look at each of its pages in a browser
	@$(BIN)/pytest docs/tests

.PHONY: man
man: .venv/library ## write the manual page of the command, dist/gpu-xform.1
	@$(BIN)/python -m docs.builder.command dist/gpu-xform.1

.PHONY: wheel
wheel: .venv/tools ## build dist/*.whl
	@$(BIN)/pip --quiet wheel --no-deps --wheel-dir dist .

.PHONY: dist
dist: .venv/tools ## build the wheel and the source archive into dist/
	@$(BIN)/python -m hatchling build --directory dist

.PHONY: clean
clean: ## remove what the other targets made
	rm -rf .venv build demo dist test-failures .hypothesis .mypy_cache .pytest_cache .ruff_cache

.venv/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or later is needed: make PYTHON=...")'
	@$(PYTHON) -m venv .venv
	@touch $@

.venv/library: .venv/python pyproject.toml
	@echo "Installing gpu_xform into .venv ..."
	@$(BIN)/pip --quiet --disable-pip-version-check install --editable .
	@touch $@

.venv/tools: .venv/python pyproject.toml
	@echo "Installing gpu_xform and its development tools into .venv ..."
ifeq ($(LOCKED),)
	@$(BIN)/pip --quiet --disable-pip-version-check install --editable '.[dev]'
else
	@$(BIN)/pip --quiet --disable-pip-version-check install --require-hashes --requirement requirements/ci.txt
	@$(BIN)/pip --quiet --disable-pip-version-check install --no-deps --editable .
endif
	@touch $@ .venv/library

.venv/bench: .venv/python pyproject.toml
	@$(BIN)/pip --quiet --disable-pip-version-check install --editable '.[bench]'
	@touch $@ .venv/library

.venv/docs: .venv/python pyproject.toml
	@echo "Installing gpu_xform and what builds its documentation into .venv ..."
	@$(BIN)/pip --quiet --disable-pip-version-check install --editable '.[docs]'
	@touch $@ .venv/library

# Shell commands that install the packages $(1), called $(2), where that may be done; elsewhere $(3) says what to do.
define install
  if [ "$$(id -u)" = 0 ]; then as_root=; elif sudo -n true 2>/dev/null || { [ -t 0 ] && sudo -v; }; then as_root=sudo; \
  else as_root=none; fi; \
  [ "$$as_root" != none ] && command -v apt-get >/dev/null && \
  echo "Installing $(2): $(1) ..." && \
  $$as_root apt-get update -qq && \
  $$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(1) >/dev/null || \
  { $(3) >&2; exit 1; }
endef

SAY_NO_DRIVER = $(BIN)/python -c \
  'from gpu_xform.gpu.drivers import install_hint; print("No Vulkan driver here.", install_hint())'
SAY_NO_BROWSER = echo "No browser here that tests can drive. Install Chromium or Chrome, and its chromedriver."
SAY_NO_SCREEN = echo "No X server here for the tests. Install Xvfb and xdotool."

# The question is put to the library itself: an installed driver may still drive nothing here.
.PHONY: driver
driver:
	@$(BIN)/python -c 'import sys, gpu_xform; sys.exit(not gpu_xform.adapters())' || { \
	  $(call install,$(DRIVER_PACKAGES),the software Vulkan driver,$(SAY_NO_DRIVER)); }

.PHONY: browser
browser:
	@command -v chromedriver >/dev/null || { \
	  $(call install,$(BROWSER_PACKAGES),a browser for the tests,$(SAY_NO_BROWSER)); }

.PHONY: screen
screen:
	@command -v Xvfb >/dev/null && command -v xdotool >/dev/null || { \
	  $(call install,$(SCREEN_PACKAGES),a screen for the tests,$(SAY_NO_SCREEN)); }
