# make demo: set up and identify the shipped example. make test: set up and run the tests. `make help` lists the rest.
PYTHON ?= python3
VENV ?= .venv
CONFIG ?= configs/demo.yaml
BIN := $(VENV)/bin
RUN := runs/$(basename $(notdir $(CONFIG)))
STAMP := $(VENV)/.installed

.PHONY: help demo test check bench pipeline clean
.DEFAULT_GOAL := help

help:
	@echo "make demo       set up, and identify the example in data/"
	@echo "make test       set up, and run the tests"
	@echo "make check      formatting, lint, types, import contracts"
	@echo "make bench      speed beside other tools, as ratios"
	@echo "make pipeline CONFIG=configs/x.yaml    every stage that is stale, rule by rule"
	@echo "make clean      remove runs/ and the environment"

$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 11) else "robotid needs Python 3.11 or later; say make PYTHON=python3.12")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --editable '.[dev]'
	@touch $@

demo: $(STAMP)
	$(BIN)/robotid run configs/demo.yaml

test: $(STAMP)
	$(BIN)/python -m pytest -n 2

check: $(STAMP)
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(STAMP)
	OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/bench/bench.py

pipeline: $(RUN)/validation.h5

$(RUN)/excitation.h5: $(CONFIG) | $(STAMP)
	$(BIN)/robotid excite $(CONFIG)
$(RUN)/records.h5: $(RUN)/excitation.h5
	$(BIN)/robotid collect $(CONFIG)
$(RUN)/rigid.h5: $(RUN)/records.h5
	$(BIN)/robotid init-rigid $(CONFIG)
$(RUN)/flex.h5: $(RUN)/rigid.h5
	$(BIN)/robotid init-flex $(CONFIG)
$(RUN)/model.h5: $(RUN)/flex.h5
	$(BIN)/robotid fit $(CONFIG)
$(RUN)/validation.h5: $(RUN)/model.h5
	$(BIN)/robotid validate $(CONFIG)

clean:
	rm -rf runs $(VENV)
