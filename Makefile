# Everything a newcomer needs: `make demo` and `make test` set themselves up on a fresh machine.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
RUNS   := $(VENV)/.runs
READY  := $(VENV)/.ready
KERNELS := $(VENV)/.kernels

# The versions to install; CONSTRAINTS=/dev/null takes the newest that pyproject.toml allows.
CONSTRAINTS ?= constraints.txt

# Of the thousands of files that pip would compile to bytecode in half a minute, a tenth is ever imported: what every
# command imports is compiled here, the rest where it is first used. Tests start hundreds of programs: also where
# PYTHONDONTWRITEBYTECODE is set, they keep bytecode. Football's kernels are compiled once per machine, in less than a minute.
USED   := import gymnasium, matplotlib.pyplot, numba, rerun, shapely, torch
CACHED := PYTHONDONTWRITEBYTECODE=
COMPILE := from regista.experiments.run.games import compile_football; compile_football()

.PHONY: setup demo policies results transfer publish grf docs test test-quick test-long torture lint format benchmark clean

setup: $(KERNELS)

# What runs need, which is all that the demo waits for; then the tools of tests and pages.
INSTALL = $(BIN)/pip install --quiet --no-compile --disable-pip-version-check --constraint $(CONSTRAINTS) --editable

$(RUNS): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Regista needs Python 3.11 or newer; set PYTHON=/path/to/python3.11")'
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) '.[all]'
	@$(CACHED) $(BIN)/python -c '$(USED)'
	@touch $@

$(READY): $(RUNS)
	$(INSTALL) '.[dev]'
	@touch $@

$(KERNELS): $(READY)
	@$(CACHED) $(BIN)/python -c '$(COMPILE)'
	@touch $@

# Mazes: random ones, beside those of a PAIRED adversary that sets θ directly. Which students solve the test mazes?
demo: $(RUNS)
	$(BIN)/regista compare maze --methods dr --seeds 7 --total-env-steps 400_000 --memory none --out demo \
		--episodes 16 --levels 0 --eval-every 200_000 --eval-episodes 8 \
		--variants "paired_direct: --method paired --ent-coef 0 --paired.adversary.builder direct --paired.adversary.ent-coef 0.1"

# The studies of RESULTS.md, about nine hours on 2 cores; what has a row in lab/studies/results is not done again. In
# parts: make publish STUDY="curricula --hours 3".
results: $(READY)
	$(BIN)/python -m lab.studies tuning --publish
	$(BIN)/python -m lab.studies curricula --publish
	$(BIN)/python -m lab.studies ablations --publish
	$(BIN)/python -m lab.paired_football --csv lab/results/paired_order.csv --publish
	$(BIN)/regista compare ued.probes:frontier --seeds 20 --levels 0 --no-record --out runs/frontier \
		--methods dr minimax paired_literal paired self_regret repaired plr robust_plr accel
	$(BIN)/python -m lab.frontier runs/frontier --publish

# What transfers to Google Research Football (`make grf` first): the tables of TRANSFER.md, an hour and a half on 2 cores.
# It goes on where it was stopped. One part, or other flags of lab.transfer: make transfer PART="policies --hours 2".
PART ?= all --hours 9
transfer: $(READY)
	$(BIN)/python -m lab.transfer $(PART)

# The table of BENCHMARK.md, from runs beneath runs/benchmark that are trained if they are missing: hours. Which study, and
# for how long: STUDY="single --seeds 5 --hours 3".
publish: $(READY)
	$(BIN)/python -m lab.studies $(or $(STUDY),generalization) --publish

# Google Research Football, for --engine grf: Debian or a like system, ten minutes; where to, says REGISTA_GRF_HOME.
grf:
	sh envs/grf/install.sh

# The documentation as a site that needs no network: build/site/index.html.
docs: $(READY)
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

# Each worker has one core: threads of torch in every one of them would only wait for each other. Workers begin with a half
# of the files each, so that what a file compiles, loads or trains for all of its tests is not done in both.
WORKERS := --numprocesses auto --dist worksteal

test: lint $(KERNELS)
	$(CACHED) OMP_NUM_THREADS=1 $(BIN)/pytest $(WORKERS) -m 'not long'

test-long: lint $(KERNELS)
	$(CACHED) OMP_NUM_THREADS=1 $(BIN)/pytest $(WORKERS)

test-quick: lint $(KERNELS)
	$(CACHED) OMP_NUM_THREADS=1 $(BIN)/pytest $(WORKERS) -m 'not slow and not long'

# Hostile states, code, files, programs, signals and matches, for MINUTES, with a report in runs/torture.json. It goes on
# where it was stopped. With bounds checks in all kernels: make torture NUMBA_BOUNDSCHECK=1.
MINUTES ?= 10
torture: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m lab.torture --minutes $(MINUTES)

lint: $(READY)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

format: $(READY)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

benchmark: $(READY)
	$(BIN)/regista benchmark

# All that running, testing and installing leaves in the checkout. Compiled kernels lie in the cache of the user.
clean:
	rm -rf $(VENV) build dist demo runs *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
