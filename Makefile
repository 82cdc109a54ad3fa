# Each target sets up what it needs on a fresh machine: a .venv here; for what draws or computes, a Vulkan driver where
# there is none; for all tests, a browser and a screen. `make PYTHON=python3.13` picks the Python that .venv is made of.

PYTHON ?= python3
BIN := .venv/bin
PYTEST := $(BIN)/pytest --numprocesses auto --maxprocesses 4
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

SECONDS ?= 300
MOMENTS ?= 200

.PHONY: fuzz
fuzz: .venv/tools ## give damaged files to every reader for SECONDS=300
	@$(BIN)/python -m tests.fuzz.readers --seconds $(SECONDS)

.PHONY: attack
attack: .venv/tools driver ## interrupt and kill commands at MOMENTS=200 random moments
	@GPU_XFORM_INTERRUPTIONS=$(MOMENTS) $(PYTEST) tests/gpu/test_interruptions.py
	@$(BIN)/python -m tests.fuzz.attack --moments $(MOMENTS)

.PHONY: wheel
wheel: .venv/tools ## build dist/*.whl
	@$(BIN)/pip --quiet wheel --no-deps --wheel-dir dist .

.PHONY: clean
clean: ## remove what the other targets made
	rm -rf .venv demo dist test-failures .hypothesis .mypy_cache .pytest_cache .ruff_cache

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
	@$(BIN)/pip --quiet --disable-pip-version-check install --editable '.[dev]'
	@touch $@ .venv/library

.venv/bench: .venv/python pyproject.toml
	@$(BIN)/pip --quiet --disable-pip-version-check install --editable '.[bench]'
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
