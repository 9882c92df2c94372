# Everything a newcomer needs: `make demo` and `make test` set themselves up on a fresh machine.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready

.PHONY: setup demo results test test-quick lint format benchmark clean

setup: $(READY)

$(READY): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Regista needs Python 3.11 or newer; set PYTHON=/path/to/python3.11")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	@touch $@

demo: $(READY)
	$(BIN)/regista compare 1v1Restricted --out demo

results: $(READY)
	$(BIN)/regista compare 1v1Free --methods dr paired_literal paired accel --seeds 5 --total-env-steps 2_000_000 \
		--num-envs 16 --num-steps 512 --out runs/results
	$(BIN)/regista probe --out runs/probe
	$(BIN)/python -m experiments.pictures.results_page runs/results runs/probe

test: lint
	$(BIN)/pytest --numprocesses auto

test-quick: lint
	$(BIN)/pytest --numprocesses auto -m 'not slow'

lint: $(READY)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

format: $(READY)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

benchmark: $(READY)
	$(BIN)/regista benchmark

clean:
	rm -rf $(VENV) build demo *.egg-info
