# make demo   one whole run on the embedded virtual joint, through real ROS nodes
# make test   the quick tests and those of the nodes; make test-slow: whole identifications and searches
# The first call makes .venv, with ROS from PyPI where no Jazzy installation is sourced.
PYTHON ?= $(firstword $(foreach p,python3.12 python3.11 python3,$(shell $(p) -c 'import sys; sys.version_info >= (3, 11) or sys.exit(1)' 2>/dev/null && echo $(p))))
VENV ?= .venv
BIN := $(VENV)/bin
# With Jazzy sourced its rclpy is used; else the same rclpy comes from PyPI (wheels exist for Python 3.11 and 3.12).
ROS_SOURCED := $(shell $(PYTHON) -c 'import rclpy' 2>/dev/null && echo yes)
ROS_PACKAGES := $(if $(ROS_SOURCED),,"ros-jazzy-rclpy[fastrtps]" ros-jazzy-common-interfaces)
CONSTRAINTS ?=

export ROS_AUTOMATIC_DISCOVERY_RANGE ?= LOCALHOST
# Two test processes on two cores: BLAS threads of their own only get in each other's way.
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: demo test test-core test-nodes test-slow test-campaign lint clean
.DEFAULT_GOAL := test

$(VENV)/.ready: setup.py
	@test -n "$(PYTHON)" || { echo "flex_ident needs Python 3.11 or newer with venv (apt install python3-venv)." >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install -q --disable-pip-version-check -e ".[test]" $(CONSTRAINTS) $(ROS_PACKAGES)
	@touch $@

demo: $(VENV)/.ready
	$(BIN)/flex_ident demo

test: test-core test-nodes

test-core: $(VENV)/.ready
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "not ros and not slow and not campaign" $(ARGS)

# The nodes mostly wait for their joints: two tests at a time, each process with a ROS domain of its own.
test-nodes: $(VENV)/.ready
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "ros and not campaign" $(ARGS)

# Whole identifications and searches, against plants that are not ours: ten minutes.
test-slow: $(VENV)/.ready
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "slow and not ros and not campaign" $(ARGS)

# Every fault in all kinds of command, each combination of settings, many topics under load, each case with each set of
# sensors: half an hour, nothing beside it.
test-campaign: $(VENV)/.ready
	$(BIN)/python -m pytest -m campaign $(ARGS)

lint: $(VENV)/.ready
	$(BIN)/pip install -q --disable-pip-version-check ruff mypy types-PyYAML
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

clean:
	rm -rf $(VENV) .venv-* build install log flex_ident_results .mypy_cache .ruff_cache
