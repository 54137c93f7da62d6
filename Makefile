# make demo: install into .venv and run the built-in example. make test, make lint: the same for contributors;
# make test-full: also what takes long (kills, long walks, many seeds, mutants).
# make fuzz: random changes of everything that is read, for hours (N=1000000 SEED=2); what fails is kept in fuzz_findings.
# make mutants: whether the tests of the method's core notice changed code (ARGS="--seed 1": another draw).
# make page: the viewer of razer view --page, from app/page/viewer into app/page/bundle; needs Node 20 or newer.
# make animation: docs/query.webp, the animation of the README, from the demo's run; needs Debian's chromium.
# make pictures: docs/*.png but those of the timeline, from runs that it makes in pictures_work; takes some minutes.
# make timeline-pictures: docs/timeline_*.png, as a browser shows them; needs Debian's chromium and takes ten minutes.
# make timeline-figures: how soon the timeline's page shows something, its size, what a run loses to its viewer.
# make test-lowest, make test-newest: make test with the lowest and the newest versions that pyproject.toml allows, in
# .venv-lowest and .venv-newest; TORCH=2.13.0 holds torch to a version, as its newest build may bring CUDA of gigabytes.
# make hashes: .ci/hashes anew, after a change of constraints.txt. VERSIONS=hashed installs by them, into a new VENV.
# make sbom: sbom.json, what is installed in .venv, in CycloneDX; OF=... lists another folder's.
# make docs: the site, into site/; any broken link or unknown name is an error.
# Any of pip's own settings applies, e.g. PIP_EXTRA_INDEX_URL or PIP_FIND_LINKS to offer a CPU build of torch.
# PYTHON=... chooses the interpreter (3.11 or 3.12), VENV=... the folder, ARGS=... goes to the program.

VENV ?= .venv
VERSIONS ?= tested
export VERSIONS
BIN := $(VENV)/bin
N ?= 100000
SEED ?= 1
OF ?= $(VENV)

.PHONY: help demo test test-full test-lowest test-newest hashes sbom fuzz mutants lint format page animation pictures timeline-pictures timeline-figures docs clean

help:
	@sed -n 's/^# //p' Makefile

demo: $(VENV)/installed
	$(BIN)/razer demo $(ARGS)

test: $(VENV)/installed-dev
	$(BIN)/python -m pytest -m "not full" $(ARGS)

test-full: $(VENV)/installed-dev
	$(BIN)/python -m pytest $(ARGS)
	$(BIN)/python -m tests.mutation

test-lowest test-newest: test-%:
	$(MAKE) test VENV=.venv-$* VERSIONS=$*

hashes:
	.ci/hash

sbom: $(VENV)/installed-dev
	.ci/sbom $(BIN)/python sbom.json $(OF)/bin/python

fuzz: $(VENV)/installed-dev
	$(BIN)/python -m tests.fuzz -n $(N) --seed $(SEED) $(ARGS)

mutants: $(VENV)/installed-dev
	$(BIN)/python -m tests.mutation $(ARGS)

lint: $(VENV)/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(VENV)/installed-dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

page:
	cd app/page/viewer && npm ci --no-audit --no-fund && npm run check && npm test && npm run build

animation: $(VENV)/installed-dev
	$(BIN)/razer demo -o demo_run
	$(BIN)/python docs/animation.py demo_run

pictures: $(VENV)/installed-dev
	$(BIN)/python docs/pictures.py pictures_work

timeline-pictures: $(VENV)/installed-dev
	$(BIN)/python -m docs.timeline_pictures timeline_work

timeline-figures: $(VENV)/installed-dev
	$(BIN)/python -m tests.timeline_figures timeline_work $(ARGS)

docs: $(VENV)/installed-docs
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

clean:
	rm -rf $(VENV) build dist site *.egg-info

# The stamps are written last, so that an installation that broke off is taken up again.
HASHES := $(wildcard .ci/hashes/*.txt)

$(VENV)/installed: pyproject.toml constraints.txt $(HASHES)
	@.ci/install $(VENV) .
	@touch $@

$(VENV)/installed-dev: pyproject.toml constraints.txt $(HASHES)
	@.ci/install $(VENV) '.[dev]'
	@touch $@ $(VENV)/installed

$(VENV)/installed-docs: pyproject.toml constraints.txt $(HASHES)
	@.ci/install $(VENV) '.[docs]'
	@touch $@ $(VENV)/installed
