# All commands of the project; `make` alone lists them.
#
#   make PYTHON=python3.12 ...      another interpreter (makes .venv anew)
#   make UV= ...                    plain pip instead of uv: slower, the same versions
#   make reproduce SNAKEMAKE_ARGS="--cores 1"
#   make test PYTEST_ARGS="-n 2 -k kernel"      all cores without -n
#   make lock LOCK_ARGS=--upgrade
#   make bench BENCH_ARGS=--docs     renew docs/performance.md, too
#   make check RESULTS=build/ci      an existing run; without RESULTS a new one
#   make reference RESULTS=build/ci REFERENCE_ARGS=--remove
#   make pages RESULTS=results       after a full run

PYTHON := python3
UV := .venv/bin/uv
SNAKEMAKE_ARGS ?=
PYTEST_ARGS ?=
LOCK_ARGS ?=
BENCH_ARGS ?=
REFERENCE_ARGS ?=
RESULTS ?=

SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
.NOTPARALLEL:

# Without bytecode Snakemake starts three times slower, and module paths of the caller's
# shell have no business in a locked environment.
unexport PYTHONDONTWRITEBYTECODE PYTHONHOME PYTHONPATH VIRTUAL_ENV
export PIP_DISABLE_PIP_VERSION_CHECK := 1

# Rules that call `python` must find the environment's. Not exported for all recipes: the
# interpreter that makes .venv must not be looked for inside it.
ACTIVE = PATH="$(CURDIR)/.venv/bin:$$PATH"

# Snakemake calls Python by a path without quotes, and Python reads it in the letters of the locale:
# a folder is usable if a shell writes its path without quotes.
ifneq ($(shell printf %q "$$(pwd -P)"),$(shell pwd -P))
$(error No job can start in $(shell pwd -P): a blank, a quote, or a letter that this locale does not \
	have. Move the clone, or, for the letters, set LC_ALL=C.UTF-8)
endif
CACHE := $(or $(XDG_CACHE_HOME),$(HOME)/.cache)
ifneq ($(shell mkdir -p "$(CACHE)" 2> /dev/null && test -w "$(CACHE)" || echo not),)
$(error The cache $(CACHE) cannot be written. Name another: XDG_CACHE_HOME=...)
endif

LOCKED := .venv/.environment pyproject.toml requirements/build.txt requirements/run.txt
SCHEMAS := workflow/schemas/config.schema.json
INSTALLER := $(filter .venv/bin/uv,$(UV))

# An environment holds absolute paths, so one that was copied or moved along with the project
# still points to the old place; it is made anew, as is one of another interpreter than asked for.
# A link that leads to the project is no other place.
ifneq ($(wildcard .venv/.origin),)
STALE := $(shell { read -r place; read -r python; } < .venv/.origin; \
	[ "$$place" = "$$(pwd -P)" ] $(if $(filter command,$(origin PYTHON)),&& [ "$$python" = "$(PYTHON)" ]) \
	|| echo stale)
endif

.PHONY: help reproduce check reference pages test lint types docs test-slurm bench test-peers lock clean distclean stale

help: ## list these targets
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1\t\2/p' Makefile | expand -t 22

reproduce: .venv/.compiled $(SCHEMAS) ## run the whole study into results/ (VERBOSE=1: say all)
	@$(ACTIVE) .venv/bin/snakemake $(SNAKEMAKE_ARGS) $(if $(VERBOSE),--verbose)

check: .venv/.compiled ## compare RESULTS=..., or a new small run, with tests/reference
ifeq ($(RESULTS),)
	rm -rf build/ci
	@$(ACTIVE) .venv/bin/snakemake $(SNAKEMAKE_ARGS) --configfile config/ci.yaml
endif
	@.venv/bin/python -m study.report.commands check $(or $(RESULTS),build/ci)

reference: .venv/.run ## show how RESULTS=... differs from tests/reference, then replace these
	@[ -n "$(RESULTS)" ] || $(call fail,which run? Say: make reference RESULTS=build/ci)
	@.venv/bin/python -m study.report.commands reference $(RESULTS) $(REFERENCE_ARGS)

pages: .venv/.run ## renew the pages with numbers, docs/deviations.md and others, from RESULTS=..., a full run
	@[ -n "$(RESULTS)" ] || $(call fail,which run? Say: make pages RESULTS=results)
	@.venv/bin/python -m study.report.commands pages $(RESULTS)

test: .venv/.test .venv/.compiled ## run the tests, on all cores
	@$(ACTIVE) .venv/bin/pytest -n auto --dist loadfile --no-loadscope-reorder $(PYTEST_ARGS)

lint: .venv/.test ## check style, workflow and the order of imports
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/snakefmt --check Snakefile workflow
	.venv/bin/lint-imports --no-cache

types: .venv/.test ## check types, strictly
	.venv/bin/mypy

docs: .venv/.test ## build the guide and the reference of the package into build/docs
	@.venv/bin/python -m study.report.commands pages
	@.venv/bin/sphinx-build -W --keep-going -q -d build/doctrees docs build/docs
	@echo "Open build/docs/index.html"

test-slurm: .venv/.test .venv/.compiled .venv-slurm/.slurm ## run a part of the study through a real Slurm on this machine
	@PATH="$$PATH:/usr/sbin"; for program in munged slurmctld slurmd sbatch; do \
		command -v $$program > /dev/null && continue; \
		{ [ "$$(id -u)" = 0 ] && apt-get update -q && apt-get install -q -y slurm-wlm munge; } \
			|| $(call fail,no $$program here. On Debian as root: apt-get install slurm-wlm munge); \
	done
	@MICROIMPACT_SLURM=1 .venv/bin/pytest tests/slurm $(PYTEST_ARGS)

bench: .venv-benchmark/.benchmark ## compare speed and error with other solvers
	.venv-benchmark/bin/python -m benchmarks.compare $(BENCH_ARGS)

test-peers: .venv-benchmark/.benchmark ## compare the physics with other solvers
	.venv-benchmark/bin/python -m pytest tests/peers --confcutdir tests/peers $(PYTEST_ARGS)

lock: .venv/bin/uv ## renew requirements/*.txt from pyproject.toml and requirements/*.in
	$(call compile,pyproject.toml --extra study,run)
	$(call compile,requirements/bootstrap.in,bootstrap)
	$(call compile,requirements/build.in -c requirements/run.txt,build)
	$(call compile,pyproject.toml --extra study requirements/test.in -c requirements/run.txt,test)
	$(call compile,pyproject.toml --extra study requirements/benchmark.in -c requirements/run.txt,benchmark)
	$(call compile,pyproject.toml --extra study requirements/slurm.in -c requirements/run.txt,slurm)

clean: ## remove results and everything else that was generated
	[ ! -d results ] || find results -mindepth 1 -maxdepth 1 ! -name README.md -exec rm -rf {} +
	rm -rf build dist .snakemake .hypothesis .mypy_cache .pytest_cache .ruff_cache

distclean: clean ## remove the environments, too
	rm -rf .venv .venv-before .venv-benchmark .venv-slurm

# One set of versions for all interpreters and platforms, so that results do not depend on them.
# No index address is written: hashes pin the files wherever they come from.
compile = .venv/bin/uv pip compile --quiet --universal --python-version 3.11 \
	--fork-strategy fewest --generate-hashes --no-emit-index-url \
	--custom-compile-command "make lock" $(LOCK_ARGS) $(1) -o requirements/$(2).txt

comma := ,
fail = { echo "make: $(1)" >&2; exit 1; }

# The environment of before stands aside until the new one is whole; if that fails, it comes back.
broken = { [ ! -e .venv-before ] || { rm -rf .venv; mv .venv-before .venv; }; $(call fail,$(1)); }

.venv/.environment: $(STALE)
	@command -v "$(PYTHON)" > /dev/null \
		|| $(call fail,no '$(PYTHON)' here. Python 3.11 or later is needed; on Debian: apt install git make python3-venv)
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| $(call fail,'$(PYTHON)' is older than 3.11. Name a newer one: make PYTHON=python3.12 ...)
	@"$(PYTHON)" -c 'import ensurepip, venv' 2> /dev/null \
		|| $(call fail,'$(PYTHON)' cannot make environments. On Debian: apt install git make python3-venv)
	@echo "Making .venv ..."
	@if [ -e .venv-before ]; then rm -rf .venv; elif [ -e .venv ]; then mv .venv .venv-before; fi
	@"$(PYTHON)" -m venv .venv || $(call broken,.venv could not be made)
	@printf '%s\n' "$$(pwd -P)" "$(PYTHON)" > .venv/.origin
	@touch $@

.venv/bin/uv: requirements/bootstrap.txt | .venv/.environment
	@.venv/bin/python -m pip install --quiet --require-hashes --only-binary :all: \
		-r requirements/bootstrap.txt \
		|| $(call broken,uv could not be installed. Without it: make UV= ...)
	@touch $@

# $(call install,ENVIRONMENT,GROUP)  All that is locked for the group, then the package itself.
# The stamps go first, lest an interrupted change pass for a finished one.
ifneq ($(UV),)
install = rm -f $(1)/.run $(1)/.test; \
	echo "Installing ..."; \
	{ "$(UV)" pip sync --quiet --python $(1)/bin/python --require-hashes \
		--build-constraints requirements/build.txt requirements/bootstrap.txt requirements/$(2).txt \
	&& "$(UV)" pip install --quiet --python $(1)/bin/python --no-deps \
		--build-constraints requirements/build.txt --editable .; \
	} || $(call broken,not installed. Behind a proxy with a certificate of its own: make UV= ...$(comma) or SSL_CERT_FILE=...); \
	$(call bytecode,$(1))$(if $(filter .venv,$(1)),; rm -rf .venv-before)
else
install = rm -f $(1)/.run $(1)/.test; \
	{ $(1)/bin/python -m pip install --require-hashes --no-deps -r requirements/build.txt \
	&& $(1)/bin/python -m pip install --require-hashes --no-deps --no-build-isolation \
		-r requirements/$(2).txt \
	&& $(1)/bin/python -m pip install --quiet --no-deps --no-build-isolation --editable .; \
	} || $(call broken,not installed); \
	$(call bytecode,$(1))$(if $(filter .venv,$(1)),; rm -rf .venv-before)
endif

# Some shells forbid Python to write any. The packages' own tests, a third of all, need none.
bytecode = $(1)/bin/python -m compileall -q -j 0 -x '/tests?/' $(1)/lib src workflow/scripts

# The test group contains the run group: once there, it serves both and is kept.
.venv/.run: $(LOCKED) | $(INSTALLER)
	@if [ -e .venv/.test ]; then \
		$(call install,.venv,test); touch .venv/.run .venv/.test; \
	else \
		$(call install,.venv,run); touch .venv/.run; \
	fi

.venv/.test: $(LOCKED) requirements/test.txt | $(INSTALLER)
	@$(call install,.venv,test); touch .venv/.run .venv/.test

# Compiled code for all jobs, once: those that start side by side would each compile the same.
# Without it a job compiles what it needs, in whatever order; then last digits may differ.
COMPILED := $(shell grep -rl --include='*.py' 'core.compiled import jit' src)

.venv/.compiled: .venv/.run $(COMPILED)
	@echo "Compiling ..."
	@.venv/bin/python -m microimpact.lab.warm
	@touch $@

# Editors complete the keys of the configuration by these.
$(SCHEMAS): .venv/.run $(shell find src -name '*.py')
	@.venv/bin/python -m study.run.schema $(@D)

.venv-benchmark/.benchmark: $(LOCKED) requirements/benchmark.txt | $(INSTALLER)
	@.venv/bin/python -m venv --clear .venv-benchmark
	@$(call install,.venv-benchmark,benchmark); touch $@

.venv-slurm/.slurm: $(LOCKED) requirements/slurm.txt | $(INSTALLER)
	@.venv/bin/python -m venv --clear .venv-slurm
	@$(call install,.venv-slurm,slurm); touch $@
