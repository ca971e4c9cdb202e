# Each target is what a person would type; `make run` and `make test` set up on their own.
PYTHON ?= python3
VENV   ?= .venv
BIN     = $(VENV)/bin
CASE   ?= inputs/stable_jump.yaml

.PHONY: run test suite check browser bench stress cross-validation validate thesis sensitivity figures times bits docs docs-test prose reference gallery measured lint doctor wheel test-repeat faults sanitize bounds slurm clean

# byte code is kept: without it every start of the program compiles all that it imports
unexport PYTHONDONTWRITEBYTECODE

# packages come by uv, and by pip where uv cannot be had or does not find them
install = uv=$$(command -v $(abspath $(BIN))/uv || command -v uv); \
	{ [ -n "$$uv" ] && "$$uv" pip install --quiet --python $(BIN)/python $(1); } || $(BIN)/pip install --quiet $(1)

# what compiling needs is installed first; the rest comes while the compiler runs
COMPILING = 'lammps[mpi]' numpy pydantic platformdirs lazy_loader

# stamps, so that the environment is made once and again when the dependencies change: .ready to run, .test to test
$(VENV)/.ready: pyproject.toml
	@echo "setting up $(VENV), once: about 40 packages, 0.7 GB on disk"
	@$(PYTHON) -m venv $(VENV)
	@command -v uv >/dev/null || $(BIN)/pip install --quiet --no-compile --disable-pip-version-check uv \
		|| echo "uv cannot be had: pip installs, which takes a minute longer"
	@$(call install,$(COMPILING))
	@echo "installing the rest, and compiling the C++ if there is a compiler"
	@{ PYTHONPATH=. $(BIN)/python -m lammps_jump.engines.plugin.make || true; } & \
		{ $(call install,--editable .); }; status=$$?; wait; exit $$status
	@touch $@

$(VENV)/.test: $(VENV)/.ready
	@echo "installing what tests need, once: about 25 packages, 0.3 GB on disk"
	@$(call install,--editable '.[test]')
	@touch $@

run: $(VENV)/.ready
	$(BIN)/lammps-jump build-and-run $(CASE)

test: lint suite

suite: $(VENV)/.test
	@$(BIN)/python tests/budget.py
	$(BIN)/python -m pytest -n 2

check: $(VENV)/.test
	$(BIN)/python -m pytest -n 2 -m "" --hypothesis-profile=random

# is every run of the tests a pass? half of them on busy cores; see tests/repeat.py
N ?= 20
test-repeat: $(VENV)/.test
	$(BIN)/python tests/repeat.py $(N)

# reports of all scenes in Chromium (Debian's package chromium): they load, play, and show what the dump holds
browser: $(VENV)/.test
	$(BIN)/python -m pytest -m browser tests/integration

# the long form of the tests of faults, some minutes; writes the table of docs/reliability.md
faults: $(VENV)/.test
	JUMP_FAULTS=long $(BIN)/python -m pytest -m fault -n 2

# address and undefined-behaviour sanitizers over the tests of the core, some minutes
SANITIZED = tests/core tests/engines/test_twin.py tests/engines/test_native_contacts.py tests/engines/test_native_slots.py \
	tests/engines/test_moving_walls.py tests/engines/test_native_sizes.py tests/studies/test_fluid.py
# of the undefined ones those that arithmetic can meet: with all of them GCC takes minutes for a unit
SANITIZING = g++ -fno-sanitize-recover=all \
	-fsanitize=address,signed-integer-overflow,shift,bounds,float-cast-overflow,integer-divide-by-zero,bool,enum
sanitize: $(VENV)/.test
	CXX="$(SANITIZING)" $(BIN)/python -c "from lammps_jump.compiling.build import library_path; from lammps_jump.core import CORE; library_path(CORE)"
	CXX="$(SANITIZING)" ASAN_OPTIONS=detect_leaks=0 LD_PRELOAD="$$(g++ -print-file-name=libasan.so) $$(g++ -print-file-name=libstdc++.so)" \
	$(BIN)/python -m pytest -p no:cacheprovider $(SANITIZED)

# the bits of the native engine in WebAssembly (node), on arm64 (qemu-user) and with SSE2 alone, and stock LAMMPS in node, a
# quarter of an hour; packages that are missing are installed, Debian's as root
bits: $(VENV)/.test
	@$(call install,--editable '.[wasm]')
	@command -v qemu-aarch64 >/dev/null && command -v npm >/dev/null || \
		{ apt-get update -q && apt-get install -q -y --no-install-recommends qemu-user nodejs npm; }
	@[ -d $(VENV)/npm ] || npm install --silent --prefix $(VENV)/npm lammps.js
	$(BIN)/python -m pytest -m "" tests/script/test_in_lammps_js.py
	$(BIN)/python tests/bits/elsewhere.py

# the core for browsers, which `lammps-jump live` puts into its pages: lammps_jump/core/browser; some minutes
.PHONY: wasm
wasm: $(VENV)/.ready
	@$(call install,--editable '.[wasm]')
	$(BIN)/python -m lammps_jump.core.browser

# the oldest versions of what pyproject.toml asks for, and the newest, with each Python from 3.11 that is here; some minutes each
bounds: $(VENV)/.test
	$(BIN)/python tests/bounds.py

# job files under a Slurm of this machine; installs Debian's packages where they are missing, as root
slurm: $(VENV)/.test
	@command -v sbatch >/dev/null || { apt-get update -q && apt-get install -q -y --no-install-recommends slurm-wlm munge; }
	$(BIN)/python -m pytest -m slurm

bench: $(VENV)/.ready
	for scene in energy_box_16 dam_break hydraulic_jump_frictionless; do $(BIN)/lammps-jump bench inputs/$$scene.yaml || exit 1; done

stress: $(VENV)/.ready
	$(BIN)/lammps-jump stress

cross-validation: $(VENV)/.ready
	for scene in energy_box_16 dam_break quick_jump hydraulic_jump_frictionless hydraulic_jump; do $(BIN)/lammps-jump cross-validate inputs/$$scene.yaml || exit 1; done

# the laws of validation/; VALIDATE="columns silo" runs those
validate: $(VENV)/.ready
	$(BIN)/lammps-jump validate $(VALIDATE)

# what the thesis says of its runs, held against ours; writes the table of docs/thesis.md
thesis: $(VENV)/.ready
	cd docs && $(abspath $(BIN))/python -m making.measured thesis

sensitivity: $(VENV)/.ready
	$(BIN)/lammps-jump sensitivity

# the picture that README.md opens with
figures: $(VENV)/.ready
	$(BIN)/python docs/figures/make.py
	$(BIN)/python docs/figures/page.py

# the table of times of README.md, some minutes
times: $(VENV)/.test
	$(BIN)/python tests/times.py

# the documentation site, docs/_build/html/index.html; its packages are the extra `docs`, about 240 MB
$(VENV)/.docs: $(VENV)/.ready
	@echo "installing what the site needs, once: about 60 packages, 240 MB"
	@$(call install,--editable '.[docs]')
	@touch $@

docs: $(VENV)/.docs
	@echo "making the reference, the tables and the gallery from what is stored; then the pages; nothing is simulated"
	$(BIN)/python -m sphinx -W --keep-going -b html docs docs/_build/html
	$(BIN)/python docs/making/check.py docs/_build/html

# words and stored tables of the site, seconds; .ci/run has it beside the tests
prose: $(VENV)/.test
	$(BIN)/python -m pytest -m prose tests/docs

# the same, and commands and numbers of tutorials and how-to pages, some minutes
docs-test: $(VENV)/.test
	$(BIN)/python -m pytest -m "docs or prose"

# the pages of docs/reference that are made from the program; a test fails where they are not those of today
reference: $(VENV)/.ready
	cd docs && $(abspath $(BIN))/python -m making.pages
	$(BIN)/python tests/fault_table.py

# what the gallery shows, docs/stored, runs all scenes; make gallery X="spillway film notebook" makes those
gallery: $(VENV)/.docs $(VENV)/.test
	cd docs && $(abspath $(BIN))/python -m making.gallery $(X)

# measures a table of the site again: make measured X=stability; without X, the list
measured: $(VENV)/.ready
	cd docs && $(abspath $(BIN))/python -m making.measured $(X)

lint: $(VENV)/.test
	$(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/mypy

# wheels for machines without a compiler, in dist/: Linux x86-64 with core and plugin, which fits the versions of LAMMPS and
# mpich of $(VENV); Linux arm64, macOS arm64 and x86-64 with the core, by the compiler of zig; a quarter of an hour
wheel: $(VENV)/.ready wasm
	$(BIN)/python -m lammps_jump.engines.plugin.make wheels

doctor: $(VENV)/.ready
	$(BIN)/lammps-jump doctor

clean:
	rm -rf $(VENV) build dist *.egg-info docs/_build docs/_made
