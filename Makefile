# Each target makes its own environment in .venv, and installs what is missing.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
PEERS := $(VENV)/.peers
# Bytecode is written even if the environment forbids it: else every process compiles each module that it loads.
export PYTHONDONTWRITEBYTECODE :=

.DEFAULT_GOAL := demo
.PHONY: demo test test-slow bench lint system clean

demo: $(READY) system
	$(BIN)/stagecad make --out build
	$(BIN)/stagecad demo --out build
	@echo
	@echo "Open build/report.html (the machine) and the report named above (the loop) in a browser."

test: $(READY) system lint
	MPLBACKEND=Agg $(BIN)/python -m pytest -n 2 --dist loadgroup -m "not slow"

# The long runs of tests/robustness print their counts; STAGECAD_ROBUSTNESS=0.01 runs a hundredth of them.
test-slow: $(READY) system
	$(BIN)/python -m pytest -n 2 --dist loadgroup -m slow

bench: $(PEERS) system
	for name in parts drawings make cold_start stick_slip many_effects loop_growth hidden_effects page; do \
		echo "== $$name"; $(BIN)/python -m benchmarks.$$name || exit 1; done

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

$(READY): pyproject.toml
	$(PYTHON) -c "import sys; sys.exit(0 if (3, 11) <= sys.version_info[:2] < (3, 14) else 'Python 3.11 to 3.13 is needed; set PYTHON=/path/to/it')"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --upgrade pip
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[dev]"
	touch $@

# Programs that a benchmark is run against.
$(PEERS): $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e ".[peers]"
	touch $@

# Libraries that the CAD kernel loads and that no Python package brings along.
system: $(READY)
	@$(BIN)/python .ci/system_libraries.py

clean:
	rm -rf build .pytest_cache .ruff_cache
