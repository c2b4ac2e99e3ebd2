# The few commands that a developer needs. Everything is set up in .venv; Python, git and make are enough.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
DEMO := demo
NAME := synthetic_freiburg1_room

.PHONY: help demo test lint docs matrix benchmarks fixtures clean

help:
	@echo "make demo        set up, make a synthetic sequence, convert it to MCAP and back, prove that nothing was lost"
	@echo "make test        set up and run all tests"
	@echo "make lint        formatting, linter, types, import rules"
	@echo "make docs        the documentation, in docs/_build"
	@echo "make matrix      every format to every other with every option, proved again; writes docs/reference/matrix.md"
	@echo "make benchmarks  figures against other tools, as ratios"

$(VENV)/.made: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

$(VENV)/.made-dev: $(VENV)/.made
	$(BIN)/python -m pip install --quiet --editable ".[plot]" --group dev
	@touch $@

demo: $(VENV)/.made
	rm -rf $(DEMO) && mkdir $(DEMO)
	$(BIN)/tumtools synth $(DEMO)/$(NAME)
	$(BIN)/tumtools convert $(DEMO)/$(NAME) $(DEMO)/$(NAME).mcap --to mcap
	$(BIN)/tumtools info $(DEMO)/$(NAME).mcap
	$(BIN)/tumtools convert $(DEMO)/$(NAME).mcap $(DEMO)/back --to tum
	$(BIN)/tumtools diff $(DEMO)/$(NAME) $(DEMO)/back

test: $(VENV)/.made-dev
	$(BIN)/python -m pytest --numprocesses 2 --dist worksteal $(ARGS)

lint: $(VENV)/.made-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

docs: $(VENV)/.made-dev
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --builder html docs docs/_build

matrix: $(VENV)/.made-dev
	$(BIN)/python docs/generate_matrix.py
	sed -n '/^| cells/,/^$$/p' docs/reference/matrix.md

benchmarks: $(VENV)/.made-dev
	for script in benchmarks/[a-z]*.py; do echo "== $$script"; $(BIN)/python $$script || echo "not measured"; done

fixtures: $(VENV)/.made
	$(BIN)/python fixtures/generate.py

clean:
	rm -rf $(VENV) $(DEMO) docs/_build .mypy_cache .ruff_cache .pytest_cache .hypothesis
