# Each target makes its own environment in .venv, and installs what is missing.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# What the demonstration needs, what the tests need besides, and the programs that a benchmark is run against.
READY := $(VENV)/.ready
TOOLS := $(VENV)/.tools
PEERS := $(VENV)/.peers
PIP := $(BIN)/python -m pip install --disable-pip-version-check --progress-bar on
# Bytecode is written even if the environment forbids it: else every process compiles each module that it loads.
export PYTHONDONTWRITEBYTECODE :=

.DEFAULT_GOAL := demo
.PHONY: demo test test-slow test-lowest sbom bench lint types style system clean

demo: $(READY) system
	$(BIN)/stagecad demo --out build
	$(BIN)/stagecad make --out build
	@echo
	@echo "Open in a browser:"
	@echo "  build/demo/report.html   the loop: a model, measurements, the effects that were missing, the error after each"
	@echo "  build/report.html        the machine: parts, drawings, checks, simulations"

# Two processes: a third one gained nothing on two cores.
test: $(TOOLS) system
	MPLBACKEND=Agg $(BIN)/python -m pytest -n 2 --dist loadgroup --no-loadscope-reorder -m "not slow"

# The long runs of tests/robustness print their counts; STAGECAD_ROBUSTNESS=0.01 runs a hundredth of them.
test-slow: $(TOOLS) system
	$(BIN)/python -m pytest -n 2 --dist loadgroup --no-loadscope-reorder -m slow

# With the lowest version of each dependency that pyproject.toml permits, in an environment of its own; TESTS selects.
LOWEST := .venv-lowest/bin
TESTS ?= -m "not slow"
test-lowest:
	$(PYTHON) -m venv .venv-lowest
	$(LOWEST)/python -m pip install --quiet uv
	$(LOWEST)/uv pip compile --quiet --resolution lowest-direct --extra dev pyproject.toml -o .venv-lowest/lowest.txt
	$(LOWEST)/python -m pip install --quiet -r .venv-lowest/lowest.txt
	$(LOWEST)/python -m pip install --quiet --no-deps -e .
	MPLBACKEND=Agg $(LOWEST)/python -m pytest -W ignore $(TESTS)

# The software bill of materials of what is installed, with the size on the disk.
sbom: $(READY)
	@mkdir -p build
	$(BIN)/python .ci/bill_of_materials.py > build/sbom.json

bench: $(PEERS) system
	for name in parts drawings make cold_start stick_slip driven_stage many_effects loop_growth hidden_effects page; do \
		echo "== $$name"; $(BIN)/python -m benchmarks.$$name || exit 1; done

# Types take a minute and the rest together half of one: they run beside each other.
lint: $(TOOLS)
	+$(MAKE) --no-print-directory -j 2 types style

types:
	$(BIN)/pyright

style:
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports

$(READY): pyproject.toml
	$(PYTHON) -c "import sys; sys.exit(0 if (3, 11) <= sys.version_info[:2] < (3, 14) else 'Python 3.11 to 3.13 is needed; set PYTHON=/path/to/it')"
	$(PYTHON) -m venv $(VENV)
	$(PIP) --quiet --upgrade pip
	@echo "Installing what the demonstration needs"
	$(PIP) -e .
	touch $@

$(TOOLS): $(READY)
	@echo "Installing what the tests need"
	$(PIP) -e ".[dev]"
	touch $@

$(PEERS): $(TOOLS)
	$(PIP) -e ".[peers]"
	touch $@

# Libraries that the CAD kernel loads and that no Python package brings along.
system: $(READY)
	@$(BIN)/python .ci/system_libraries.py

clean:
	rm -rf build .venv-lowest .pytest_cache .ruff_cache
