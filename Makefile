# The two commands: `make` sets up and runs the workflow, `make test` runs the tests.
# `make help` lists the rest.

PYTHON ?= python3
CORES ?= 2
ARGS ?=
RESULTS ?= $(if $(findstring profiles/quick,$(ARGS)),results/quick,results)
# RESULTS is the folder of the run and of the report. Snakemake reads only the last --config.
FOLDER := $(if $(filter command,$(origin RESULTS)),results=$(RESULTS))
WITH = $(if $(FOLDER),$(if $(filter --config,$(ARGS)),$(patsubst --config,--config $(FOLDER),$(ARGS)),$(ARGS) --config $(FOLDER)),$(ARGS))
BIN := .venv/bin
LOCK := requirements/requirements.txt
# The certificates of the system, or those of SSL_CERT_FILE: behind a proxy that inspects TLS, its own is there.
CERTS = $(shell $(PYTHON) -c 'import ssl; p = ssl.get_default_verify_paths(); print(p.cafile or p.capath or "")' 2>/dev/null)
# Settings of the machine's pip and python must not leak into a locked environment.
CLEAN = env -u PYTHONDONTWRITEBYTECODE -u PIP_FIND_LINKS -u PIP_EXTRA_INDEX_URL -u PYTHONPATH \
	-u VIRTUAL_ENV PIP_CONFIG_FILE=/dev/null PIP_DISABLE_PIP_VERSION_CHECK=1 \
	UV_SYSTEM_CERTS="$${UV_SYSTEM_CERTS:-1}" PIP_CERT="$${PIP_CERT:-$${REQUESTS_CA_BUNDLE:-$(CERTS)}}"
RUN := env -u PYTHONDONTWRITEBYTECODE -u PYTHONPATH PATH="$(CURDIR)/$(BIN):$$PATH"

.DEFAULT_GOAL := run
.PHONY: run check report env warm test fuzz mutants test-everywhere test-interrupted test-cluster study lint crate hooks peers s3 benchmark accuracy lock samples site pictures docs graph clean help

run: warm  ## set up, then regenerate every table and figure (the default)
	@$(RUN) python workflow/run.py --cores $(CORES) $(if $(FOLDER),--config $(FOLDER))

# A run with refusals ends with status 1, and the report lists them; it cannot list results missing after a crash.
report: warm  ## run, then write the report: results/report.html (quick: make report ARGS="--profile profiles/quick")
	@status=0; $(RUN) python workflow/run.py --cores $(CORES) $(WITH) || status=$$?; \
	$(RUN) python workflow/write_report.py $(RESULTS)/report.html $(WITH) || exit 1; exit $$status

# Names as they were typed: through the environment neither make nor the shell reads a $ or a ` in them.
# RESULTS has a default of its own, which is that of whole runs.
export CHECK_FILE := $(value FILE)
export CHECK_MARKERS := $(value MARKERS)
export CHECK_NAMES := $(value NAMES)
export CHECK_BOARD := $(value BOARD)
export CHECK_POINTS := $(value POINTS)
export CHECK_LENGTH := $(value LENGTH)
export CHECK_BAR := $(value BAR)
export CHECK_FACTORY := $(value FACTORY)
export CHECK_REFERENCE := $(value REFERENCE)
export CHECK_RECEIVER := $(value RECEIVER)
export CHECK_LABELS := $(value RECEIVER_LABELS)
export CHECK_RESULTS := $(if $(filter command,$(origin RESULTS)),$(value RESULTS))
check: env  ## the verdict on one file: make check FILE=take.c3d [MARKERS="A;B"] [RATE=100] [UNIT=mm] [NAMES="t x y z"] [TRUNCATED=accept] [RESULTS=folder]; of a bar that is moved: make check FILE=wand.c3d BAR=A-B|auto [LENGTH_MM=500] [LENGTH_U_MM=0.05]; of a sweep dump: make check FILE=dump.bin BOARD=board.csv [WORLD=gravity|master|board-start] [POINTS=room.csv] [LENGTH="stations 4.330 0.005"] [FACTORY=stations.json] [REFERENCE=pose.json] [INERTIAL=use] [BAR=T20-T21] [RECEIVER=take.c3d] [RECEIVER_LABELS="A;B"]
	@test -n "$$CHECK_FILE" || { echo 'make check needs a file: make check FILE=take.c3d' >&2; exit 1; }
	@$(RUN) python -m mocap_metrology check --threads "$(CORES)" \
		$${CHECK_BAR:+--bar="$$CHECK_BAR"} $(if $(LENGTH_MM),--length "$(LENGTH_MM)") $(if $(LENGTH_U_MM),--length-u "$(LENGTH_U_MM)") \
		$(if $(WORLD),--world "$(WORLD)") $${CHECK_POINTS:+--world-points="$$CHECK_POINTS"} \
		$${CHECK_LENGTH:+--known-length="$$CHECK_LENGTH"} \
		$${CHECK_FACTORY:+--factory="$$CHECK_FACTORY"} $${CHECK_REFERENCE:+--reference="$$CHECK_REFERENCE"} \
		$${CHECK_RECEIVER:+--receiver="$$CHECK_RECEIVER"} $${CHECK_LABELS:+--receiver-labels="$$CHECK_LABELS"} \
		$(if $(filter use,$(INERTIAL)),--inertial) $(if $(RATE),--rate "$(RATE)") \
		$(if $(UNIT),--unit "$(UNIT)") $(if $(filter accept,$(TRUNCATED)),--accept-truncated) \
		$${CHECK_MARKERS:+--markers="$$CHECK_MARKERS"} $${CHECK_NAMES:+--columns="$$CHECK_NAMES"} --output="$$CHECK_RESULTS" $${CHECK_BOARD:+--board="$$CHECK_BOARD"} \
		-- "$$CHECK_FILE"

env: .venv/.ready  ## set up only: .venv/ with pinned, hashed, byte-compiled requirements

.venv/.ready: $(LOCK) requirements/uv.txt pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "mocap-metrology needs Python >= 3.11; name one with: make PYTHON=python3.13" >&2; exit 1; }
	@rm -f $@
	@$(PYTHON) -m venv --clear .venv 2>/dev/null && $(BIN)/python -m pip --version >/dev/null 2>&1 || \
		{ rm -rf .venv; echo "$(PYTHON) cannot make a virtual environment; install its venv package" \
		"(Debian, Ubuntu: apt-get install python3-venv) or name another: make PYTHON=python3.13" >&2; exit 1; }
	$(CLEAN) $(BIN)/python -m pip install --quiet --require-hashes -r requirements/uv.txt
	$(CLEAN) VIRTUAL_ENV=.venv $(BIN)/uv pip sync --quiet --require-hashes --compile-bytecode $(LOCK) requirements/uv.txt
	$(CLEAN) VIRTUAL_ENV=.venv $(BIN)/uv pip install --quiet --no-deps --no-build-isolation -e .
	$(RUN) python -m mocap_metrology.common.compiled
	@touch $@

# numba's cache has no lock: after an edit of a kernel one process compiles, not several at once.
warm: env
	@$(RUN) python -m mocap_metrology.common.compiled

test: warm  ## run the tests
	@$(RUN) OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1 python -m pytest \
		--numprocesses $(CORES) --dist loadfile --no-loadscope-reorder

test-everywhere: warm  ## compare all results of two runs: processors, order of rows, time zone, locale, folder, checkout
	@$(RUN) OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python -m pytest -m everywhere tests/workflow/test_everywhere.py

test-interrupted: warm  ## disturb runs at random moments, then compare with an undisturbed one: make test-interrupted ARGS="--runs 3"
	@$(RUN) PYTHONPATH=tests:tests/workflow:workflow python tests/interrupted.py $(ARGS)

test-cluster: warm  ## run the workflow on a SLURM cluster of this computer, with a node lost (tests/cluster/install.sh, as root)
	@$(RUN) OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 sh tests/cluster/run.sh python -m pytest -m cluster tests/cluster

fuzz: warm  ## damage inputs of every kind and judge what is read (ARGS="--seed 2"; 2 to 10 minutes)
	@$(RUN) OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1 python -m tests.fuzz --workers $(CORES) $(ARGS)

mutants: warm  ## change single lines of the package and list the changes that no test notices (ARGS="--seed 1 --number 300"; hours)
	@$(RUN) python -m tests.mutants $(ARGS)

study: warm  ## run the long Monte Carlo studies
	@$(RUN) OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1 python -m pytest -m study

lint: env  ## check style, spelling and types of code and workflow
	@$(RUN) sh -ec 'ruff check .; ruff format --check .; codespell; \
		snakefmt --check Snakefile workflow; python workflow/lint.py; mypy'

crate: env  ## pack a finished run as a Workflow Run RO-Crate: results/crate.zip
	@$(RUN) python workflow/write_crate.py $(RESULTS)

hooks: env  ## check style and spelling before each commit from now on
	@$(BIN)/pre-commit install

peers: env  ## install optional parts: OpenCV for the estimator pnp, and the peers of make benchmark (needs a C compiler)
	@$(CLEAN) VIRTUAL_ENV=.venv $(BIN)/uv pip install --quiet --require-hashes -r requirements/peers.txt

s3: env  ## install what reads recordings in S3 (docs/cluster.md)
	@$(CLEAN) VIRTUAL_ENV=.venv $(BIN)/uv pip install --quiet --require-hashes -r requirements/s3.txt

benchmark: warm peers  ## compare run times with those of the peers
	@$(RUN) python -m benchmarks.peers
	@$(RUN) python -m benchmarks.noise_times
	@$(RUN) python -m benchmarks.lighthouse_times

accuracy: warm  ## measure by Monte Carlo how often findings are right; takes hours (docs/accuracy.md; one subject: make accuracy ARGS=lines)
	@$(RUN) OMP_NUM_THREADS=1 python -m benchmarks.sentences $(ARGS)
	@test -n "$(ARGS)" || $(RUN) python -m benchmarks.noise_monte_carlo
	@test -n "$(ARGS)" || $(RUN) python -m benchmarks.failing_camera

lock: .venv/.ready  ## recompile requirements/*.in
	@cd requirements && for name in requirements uv peers docs s3; do \
		$(CLEAN) ../$(BIN)/uv pip compile --quiet --universal --fork-strategy fewest --generate-hashes \
		--python-version 3.11 --no-header --no-annotate -o $$name.txt $$name.in >/dev/null; done

samples: env  ## fetch recordings by other people, which tests and examples read: make samples [FROM=folder]
	@$(RUN) python workflow/fetch_samples.py $(if $(FROM),--from "$(FROM)")

site: env  ## build the pages of docs/: build/site/index.html
	@$(CLEAN) VIRTUAL_ENV=.venv $(BIN)/uv pip install --quiet --require-hashes -r requirements/docs.txt
	@$(RUN) python -m sphinx -E -W --keep-going -q -b html docs build/site

PICTURES := recordings/T40-10/verdict.png recordings/T40-10/adev.png recordings/T40-10/fit \
	recordings/T40-10-crump/diagnosis.png calibrations/twin-1-1/calibration.png
pictures: warm  ## redraw the pictures of README.md and docs from nine-hour twins
	@$(RUN) python workflow/run.py --cores $(CORES) $(PICTURES:%=results/%)
	cp results/recordings/T40-10/verdict.png docs/T40-10_verdict.png
	cp results/recordings/T40-10/adev.png docs/T40-10_adev.png
	cp results/recordings/T40-10/fit/z1.png docs/T40-10_z1_fit.png
	cp results/recordings/T40-10-crump/diagnosis.png docs/T40-10-crump_diagnosis.png
	cp results/calibrations/twin-1-1/calibration.png docs/twin-1-1_calibration.png

docs: env  ## regenerate the tables of config/README.md and workflow/schemas from the models
	@$(RUN) PYTHONPATH=workflow python -m mocap_workflow.document

graph: env  ## redraw the rule graph of docs/rule_graph.md (needs Graphviz)
	@$(RUN) python workflow/rule_graph.py

clean:  ## remove the environment, not the results
	rm -rf .venv

help:
	@grep -hE '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14
