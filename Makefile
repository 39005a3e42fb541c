# Two commands on a fresh machine: `make demo` searches a real level crossing, `make test` checks everything.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DEMO := demo-run
POSTGRESQL := $(shell command -v initdb || ls /usr/lib/postgresql/*/bin/initdb 2>/dev/null)
WITHOUT_SYSTEM := $(shell command -v chromium >/dev/null 2>&1 && test -n "$(POSTGRESQL)" || echo "not system")
WITHOUT_TORCH = $(shell $(BIN)/python -c "import torch" 2>/dev/null || echo "not torch")
WITHOUT_FEM = $(shell $(BIN)/python -c "import skfem" 2>/dev/null || echo "not fem")
MARK = $(subst $() not, and not,$(strip $(WITHOUT_SYSTEM) $(WITHOUT_TORCH) $(WITHOUT_FEM)))

# Tests start a hundred processes; each would compile all modules again.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test lint benchmark clean

demo: $(VENV)/run.stamp
	$(BIN)/railsearch run level-crossing --strategy dycors --scalarise asf --budget 200 --seed 1 --out $(DEMO)
	@echo "Look into $(DEMO)/report.html, or start: $(BIN)/railsearch dashboard $(DEMO)"

test: $(VENV)/test.stamp lint
	$(BIN)/pytest -n 2 --dist loadfile --no-loadscope-reorder -m "$(MARK)"
	@test -z "$(MARK)" || $(BIN)/pytest --collect-only -q -m "not ($(MARK))" 2>/dev/null | sed -n 's/^tests.*::/left out for want of Chromium, PostgreSQL, PyTorch or scikit-fem: &/p'

lint: $(VENV)/test.stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

benchmark: $(VENV)/test.stamp
	$(BIN)/python benchmarks/level_crossing_speed.py

clean:
	rm -rf $(VENV) $(DEMO) build dist *.egg-info

$(BIN)/python:
	$(PYTHON) -c 'import sys; sys.exit("railsearch needs Python 3.11 or newer" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)

$(VENV)/run.stamp: $(BIN)/python pyproject.toml constraints.txt
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable .
	@touch $@

$(VENV)/test.stamp: $(BIN)/python pyproject.toml constraints.txt
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable ".[test]"
	@touch $@ $(VENV)/run.stamp
