# make demo: set up and identify the shipped example. make test: set up and run the tests. `make help` lists the rest.
PYTHON ?= $(shell for p in python3 python3.14 python3.13 python3.12 python3.11; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
VENV ?= .venv
CONFIG ?= configs/demo.yaml
BIN := $(VENV)/bin
ROBOTID := $(BIN)/robotid
RUN := runs/$(basename $(notdir $(CONFIG)))
STAMP := $(VENV)/.installed

.PHONY: help install demo test slow check compatibility bench trials chaos picture docs pipeline clean
.DEFAULT_GOAL := help

help:
	@echo "make demo       set up, and identify the example in data/"
	@echo "make test       set up, and run the tests"
	@echo "make slow       the long trials that make test leaves out"
	@echo "make check      formatting, lint, types, import contracts"
	@echo "make compatibility   a fresh install on the lowest and newest versions, on every Python of this machine"
	@echo "make bench      speed beside other tools, as ratios"
	@echo "make trials     effects hidden in an independent plant: hours, begun again where it was left; table to the manual"
	@echo "make chaos      runs killed at random moments, files with random damage: ten minutes"
	@echo "make picture    the picture of the README, from a run of configs/hidden.yaml"
	@echo "make docs       the parts of the manual that are made from the code"
	@echo "make pipeline CONFIG=configs/x.yaml    every stage that is stale, rule by rule"
	@echo "make clean      remove runs/, caches and the environment"
	@echo "PYTHON=python3.12 chooses the interpreter, VENV=folder where the environment is"

$(STAMP): pyproject.toml
	@test -n "$(PYTHON)" || { echo "robotid needs Python 3.11 or later; name it: make PYTHON=/path/to/python3" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit("robotid needs Python 3.11 or later, %s is %d.%d; name another: make PYTHON=..." \
		% (sys.executable, *sys.version_info[:2]) if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@

install: $(STAMP)

demo: $(STAMP)
	$(ROBOTID) run configs/demo.yaml

test: $(STAMP)
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder

slow: $(STAMP)
	$(BIN)/python -m pytest -n 2 -m slow

# COMPATIBILITY='--python python3.13 --only lowest' selects, --corners what the gate tries; environments are kept in .compatibility/.
compatibility:
	PYTHONPATH=tests $(PYTHON) -m compatibility $(COMPATIBILITY)

check: $(STAMP)
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(STAMP)
	OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/bench/bench.py $(BENCH)

# TRIALS='--only motor.stribeck --draws 2' selects; results are kept in trials/.
trials: $(STAMP)
	OPENBLAS_NUM_THREADS=1 PYTHONPATH=tests $(BIN)/python -m study --manual $(TRIALS)

# CHAOS='--seed 3 --kills 20' selects.
chaos: $(STAMP)
	OPENBLAS_NUM_THREADS=1 PYTHONPATH=tests $(BIN)/python -m chaos $(CHAOS)

picture: $(STAMP)
	$(ROBOTID) run configs/hidden.yaml
	$(BIN)/python data/make_picture.py runs/hidden data/picture.svg

docs: $(STAMP)
	PYTHONPATH=tests $(BIN)/python -m support.manual

# One rule a stage. What make finds stale by time, robotid checks by content: what turns out fresh is only touched.
# Measured files are those that the configuration names; one that is missing is left for robotid to report.
HERE := $(dir $(CONFIG))
NAMED := $(shell sed -n -e 's/^[^\#]*file: *\[\([^]]*\)\].*/\1/p' -e t -e 's/^[^\#]*file: *\([^ ,}\#]*\).*/\1/p' $(CONFIG) 2>/dev/null \
	| tr -d "'\"" | tr ',' ' ')
EXCITATION := $(if $(shell sed -n '/^[^\#]*excite: */p' $(CONFIG) 2>/dev/null),$(RUN)/excitation.h5)
FILES := $(wildcard $(patsubst $(HERE)/%,/%,$(addprefix $(HERE),$(NAMED))))

pipeline: $(RUN)/report.html

$(RUN)/excitation.h5: $(CONFIG) | $(STAMP)
	$(ROBOTID) excite $(CONFIG)
$(RUN)/records.h5: $(CONFIG) $(EXCITATION) $(FILES)
	$(ROBOTID) collect $(CONFIG)
$(RUN)/rigid.h5: $(CONFIG) $(RUN)/records.h5
	$(ROBOTID) init-rigid $(CONFIG)
$(RUN)/flex.h5: $(CONFIG) $(RUN)/records.h5 $(RUN)/rigid.h5
	$(ROBOTID) init-flex $(CONFIG)
$(RUN)/model.h5: $(CONFIG) $(RUN)/records.h5 $(RUN)/rigid.h5 $(RUN)/flex.h5
	$(ROBOTID) fit $(CONFIG)
$(RUN)/validation.h5: $(CONFIG) $(RUN)/records.h5 $(RUN)/rigid.h5 $(RUN)/flex.h5 $(RUN)/model.h5
	$(ROBOTID) validate $(CONFIG)
$(RUN)/diagnosis.h5: $(CONFIG) $(RUN)/records.h5 $(RUN)/model.h5
	$(ROBOTID) diagnose $(CONFIG)
$(RUN)/extension.h5: $(CONFIG) $(RUN)/records.h5 $(RUN)/model.h5 $(RUN)/diagnosis.h5
	$(ROBOTID) extend $(CONFIG)
$(RUN)/report.html: $(RUN)/validation.h5 $(RUN)/extension.h5
	$(ROBOTID) report $(CONFIG)
# Ctrl-C leaves the last iterate saved, and a validation below its threshold can be looked at.
.PRECIOUS: $(addprefix $(RUN)/,excitation.h5 records.h5 rigid.h5 flex.h5 model.h5 validation.h5 diagnosis.h5 extension.h5)

clean:
	rm -rf runs $(VENV) .compatibility .mypy_cache .pytest_cache .ruff_cache .import_linter_cache .hypothesis
