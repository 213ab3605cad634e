# roughbench: `make help` lists what there is.
#
# Every target that needs Python sets up .venv first: nothing has to be installed by hand,
# and it happens again only when pyproject.toml changes.

PYTHON ?= $(shell for python in python3 python3.13 python3.12 python3.11 python3.14; do \
	$$python -c 'import ensurepip, sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 \
	&& echo $$python && break; done)
JOBS ?= $(shell nproc 2>/dev/null || echo 1)
BIN := .venv/bin
MINIMUM := .venv-minimum
# Each worker begins with its own part of the tests, whose fixtures it keeps; the first that has
# finished takes tests from the others. Half as many workers again as cores: tests wait for
# processes, locks and clocks.
PARALLEL := -n $(shell expr $(JOBS) + $(JOBS) / 2) --dist worksteal
# With the bytecode of the tests kept, whatever the environment says: to make it takes longer than
# to import them, in each worker.
PYTEST := PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest $(PARALLEL)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help demo units test test-all test-minimum lint smoke fig1 fig2 fig3 fig4 figures paper-fig3 \
	paper-fig4 paper-bem study study-page study-figures study-contenders \
	study-fields study-size study-rolloff study-below study-hurst study-cutoff \
	study-resolution study-ladder study-slope-8 study-slope-32 study-slope-32-coarse \
	study-slope-128-few study-slope-128 study-slope-512 study-paper-size \
	study-contenders-256 study-cells study-exponents-8 study-exponents-64 study-gaussian study-points study-finite-size \
	study-finite-size-rolloff study-theory compare compare-tamaas compare-conventions compare-scans \
	notebooks outside-model preparation faults \
	hard bench \
	site site-links readme-figures models dist dist-check clean distclean setup setup-dev setup-docs python

help: ## this list
	@awk -F ':.*## ' '/^[a-z0-9-]+:.*## / { printf "  make %-27s%s\n", $$1, $$2 }' Makefile
	@echo
	@echo "  PYTHON=/path/to/python3 chooses the Python (3.11 or newer) of .venv, JOBS=N how many"
	@echo "  tasks run at once. Results go to results/, figures to figures/."

STUDIES := contenders fields size rolloff below hurst cutoff resolution
# What docs/study.md rests on, the quickest first; and what would be needed beyond.
KEPT := ladder slope-32-coarse contenders-256 cells exponents-64 exponents-8 gaussian points \
	finite-size finite-size-rolloff slope-128-few slope-8 \
	slope-32 slope-128 theory
LARGE := slope-512 paper-size

## -- computing -------------------------------------------------------------------------

# The figures that each run is drawn for; empty: all that its results allow.
FIGURES_fig1 = foundation
FIGURES_fig2 = spectrum
FIGURES_fig3 = printed_fig3 fig3 area separation
FIGURES_fig4 = printed_fig4 stiffness
FIGURES_paper-fig3 = printed_fig3 fig3 area separation
FIGURES_paper-fig4 = printed_fig4 stiffness
FIGURES_paper-bem = fig3 area separation stiffness

# Results whose models are drawn beside, where they are there: exact points of `make paper-bem`.
BESIDE_paper-fig3 = $(wildcard results/paper-bem.h5)
BESIDE_paper-fig4 = $(wildcard results/paper-bem.h5)

# $(call compute,NAME,SPEC): run SPEC into results/NAME.h5, draw it into figures/NAME/.
define compute
	@mkdir -p results
	$(BIN)/roughbench run $(2) -j $(JOBS) -o results/$(1).h5
	$(BIN)/roughbench plot results/$(1).h5 -o figures/$(1) \
		$(addprefix --figure ,$(FIGURES_$(1))) $(addprefix --with ,$(BESIDE_$(1)))
endef

demo: setup ## all three models on the same surfaces, and their figures: two minutes
	$(call compute,quick,configs/quick.yaml)

units: setup ## a surface and a material in physical units: ten seconds
	$(call compute,$@,configs/$@.yaml)

fig1 fig2 fig3 fig4: setup
	$(call compute,$@,configs/$@.yaml)

fig1: ## the foundation of springs (the paper's Fig. 1)
fig2: ## the spectrum (Fig. 2)
fig3: ## area and separation, q1 = 128 q0 (Fig. 3)
fig4: ## stiffness, q1 = 256 q0 (Fig. 4)

figures: demo fig1 fig2 fig3 fig4 ## demo and the four figures above

paper-fig3 paper-fig4 paper-bem: setup
	$(call compute,$@,configs/paper/$(@:paper-%=%).yaml)

paper-fig3: ## area and separation at the paper's q1 = 8192 q0, as Fig. 3
paper-fig4: ## stiffness at the paper's q1 = 8192 q0, as Fig. 4
paper-bem: ## the exact solver at q1 = 8192 q0: 13.5 GB of memory, two hours

$(STUDIES:%=study-%) $(KEPT:%=study-%) $(LARGE:%=study-%): setup
	$(call compute,$@,configs/study/$(@:study-%=%).yaml)

study-page: $(KEPT:%=study-%) ## every run that docs/study.md rests on, and the page; hours
	$(BIN)/python scripts/study_figures.py --keep results

study-figures: setup ## numbers, figures and docs/study.md from the kept results; a minute
	$(BIN)/python scripts/study_figures.py

study: $(STUDIES:%=study-%) ## every run of the study and its report: an hour
	$(BIN)/roughbench report $(STUDIES:%=results/study-%.h5) -o figures/study.html

study-contenders: ## every contender on the same surfaces, q1 = 512 q0
study-fields: ## distributions, spectra, patches and maps of the contact
study-size: ## the same spectrum in larger and larger cells
study-rolloff: ## the roll-off from 1 to 128 q0
study-below: ## below the roll-off: a flat spectrum, or nothing
study-hurst: ## the Hurst exponent from 0.3 to 0.9
study-cutoff: ## the cut-off from 32 to 1024 q0
study-resolution: ## the same surfaces on finer and finer grids
study-ladder: ## from the half-space to springs, by a largest wave that couples
study-slope-8: ## local slope of ū over ln p at q1 = 8 q_r, 4096 bumps
study-slope-32: ## the same at 32 q_r
study-slope-32-coarse: ## the same on two points per shortest wave
study-slope-128-few: ## the same at 128 q_r, 64 bumps
study-slope-128: ## the same at 128 q_r; hours
study-slope-512: ## the same at 512 q_r, 8192² points; many hours
study-paper-size: ## q1 = 8192 q0, few loads, 16384² points; many hours, 13.5 GB
study-contenders-256: ## every contender, q1 = 256 q0; with distributions and spectra
study-cells: ## q1 = 8 q_r in cells with 256 and 1024 bumps of the roll-off
study-exponents-8: ## H from 0.3 to 0.9 with 64 bumps of the roll-off
study-exponents-64: ## the same with 4096
study-gaussian: ## Gaussian amplitudes beside fixed ones
study-points: ## two, four and eight points on the shortest wave
study-finite-size: ## the finite-size law, eq. (10), for four H
study-finite-size-rolloff: ## the same for q_r = 2 and 4 q0
study-theory: ## the theory's own K ∼ p at the paper's cut-off; seconds

## -- checking --------------------------------------------------------------------------

test: setup-dev ## unit tests and doctests, without those marked slow
	$(PYTEST) -m "not slow"

test-all: setup-dev ## all tests
	$(PYTEST)

test-minimum: $(MINIMUM)/ready ## tests with the oldest versions of the dependencies (Python 3.11)
	$(MINIMUM)/bin/python -m pytest $(PARALLEL) -m "not slow" -o filterwarnings=default tests/cli tests/engines \
		tests/figures tests/observables tests/planning tests/report tests/rundir tests/runner \
		tests/spec tests/test_*.py

$(MINIMUM)/ready: pyproject.toml scripts/minimum_versions.py | setup
	$(BIN)/python -m venv --clear --without-pip $(MINIMUM)
	$(BIN)/python scripts/minimum_versions.py dask > $(MINIMUM)/constraints.txt
	$(BIN)/python -m pip --python $(MINIMUM)/bin/python install --quiet \
		--constraint $(MINIMUM)/constraints.txt --editable '.[test]'
	touch $@

lint: setup-dev ## ruff and mypy
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

smoke: setup ## every command once, on tiny grids
	PATH="$(CURDIR)/$(BIN):$$PATH" sh scripts/smoke.sh

notebooks: python .venv/ready-notebooks ## the notebooks of examples/, run into build/notebooks; a minute
	$(BIN)/python scripts/run_notebooks.py build/notebooks

outside-model: setup ## a model of one's own, from init to the report, in a fresh environment
	sh scripts/check_outside_model.sh $(BIN)/python

compare: setup ## the models against an independent prototype's numbers
	$(BIN)/python scripts/compare_reference.py

compare-tamaas: setup ## the exact solver against Tamaas, in an environment of its own
	$(BIN)/python scripts/compare_tamaas.py

compare-conventions: setup ## each line of docs/conventions.md against the code that it is about
	$(BIN)/python scripts/compare_conventions.py

compare-scans: setup-dev ## what is read from the topographies in FOLDER, against SurfaceTopography
	@test -n "$(FOLDER)" || { echo "error: say which folder: make compare-scans" \
		"FOLDER=/path/to/topographies" >&2; exit 1; }
	$(BIN)/python scripts/compare_scans.py "$(FOLDER)"

preparation: setup ## what the preparation of a scan does to the answer, as a table; minutes
	$(BIN)/python scripts/preparation_effects.py

faults: setup-dev ## a campaign of kills and full disks; three quarters of an hour
	$(BIN)/python scripts/fault_campaign.py

hard: setup ## the exact solver on forty hard surfaces; counts what does not converge; ten minutes
	$(BIN)/python scripts/hard_surfaces.py

bench: setup ## the benchmarks in scripts/
	@for script in scripts/bench_*.py; do \
		echo "== $$script"; $(BIN)/python $$script || exit 1; done

## -- releasing -------------------------------------------------------------------------

site: setup-docs ## pages, reference and notebooks as a site, in build/site; all its links checked
	$(BIN)/python scripts/run_notebooks.py build/notebooks
	$(BIN)/python website/build.py

site-links: site ## whether the links that lead out of the site answer; needs a network
	$(BIN)/python website/build.py --linkcheck

readme-figures: demo ## the figures in docs/figures, drawn again
	@mkdir -p docs/figures
	cp figures/quick/area.png figures/quick/stiffness.png docs/figures/

models: setup ## every model on the same surfaces, and the figures of docs/models; minutes
	@mkdir -p results
	$(BIN)/roughbench run configs/models.yaml -j $(JOBS) -o results/models.h5
	$(BIN)/python scripts/model_figures.py results/models.h5

dist: setup-dev ## wheel and source archive in dist/
	rm -rf dist
	$(BIN)/python -m build

dist-check: dist ## both of them, each in a fresh environment
	sh scripts/check_dist.sh $(BIN)/python

## -- setting up ------------------------------------------------------------------------

setup: python .venv/ready
setup-dev: python .venv/ready-dev
setup-docs: python .venv/ready-docs

.venv/bin/python: | python
	$(PYTHON) -m venv --clear .venv

.venv/ready: pyproject.toml | .venv/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

.venv/ready-dev: .venv/ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@

.venv/ready-notebooks: .venv/ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[notebooks]'
	@touch $@

.venv/ready-docs: .venv/ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	@touch $@

python:
	@test -n "$(PYTHON)" || { echo "error: no Python 3.11 or newer with venv found; install one" \
		"(Debian: apt-get install python3-venv), or name it: make PYTHON=/path/to/python3 ..." \
		>&2; exit 1; }

clean: ## remove results, figures, caches and builds
	rm -rf results figures build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +

distclean: clean ## remove .venv too
	rm -rf .venv $(MINIMUM)
