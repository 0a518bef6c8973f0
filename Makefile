# `make demo` and `make test` do all the set-up they need; scripts/bootstrap says what that is.

# rustup's directory, in case this shell is older than the installation.
export PATH := $(or $(CARGO_HOME),$(HOME)/.cargo)/bin:$(PATH)
export VIRTUAL_ENV := $(CURDIR)/.venv
export PYO3_PYTHON := $(VIRTUAL_ENV)/bin/python
# A conda or ROS shell must not leak its packages into ours.
unexport CONDA_PREFIX PYTHONHOME PYTHONPATH

bin := .venv/bin
rust_sources := Cargo.toml Cargo.lock $(shell find rust -type f)
# A file's tests stay in one of WORKERS processes. Their libraries share out no work of their own, which would only
# make them wait for each other.
pytest := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(bin)/python -m pytest --dist loadfile --no-loadscope-reorder

.PHONY: help venv build dev demo check test test-rust lint-rust test-python lint-python types stubs docs soak laws bench \
	format wheel clean

help:  ## this list
	@echo 'make TARGET, with ARGS="..." for the demo and PYTHON=python3.12 to choose the interpreter of a new .venv'
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  %-12s %s\n", $$1, $$2 }' Makefile

venv: .venv/dev-ready  ## .venv with every package, and the system libraries of Open3D
build: .venv/extension-release  ## the Rust extension, optimised, and beltsort importable in .venv
dev: .venv/extension-dev  ## the same, compiled in seconds after an edit; it plans a few times slower

demo: build  ## run the main job: beltsort demo $(ARGS)
	$(bin)/beltsort demo $(ARGS)

check: .venv/checked-rust .venv/extension-any venv  ## after an edit: linters, types, tests without processes or seconds
	$(MAKE) lint-python
	$(bin)/python -m mypy
	$(pytest) -n $(or $(WORKERS),2) -m "not process and not slow and not soak"

# Two at a time: some wait for one core, others for servers.
test:  ## every test and check
	$(MAKE) -j2 test-rust lint-rust test-python lint-python types docs

test-rust: venv  ## cargo test
	cargo test

lint-rust: venv  ## clippy, rustdoc and rustfmt
	cargo clippy --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps
	cargo fmt --all --check

# More processes than cores: many tests wait for servers that they have started.
test-python: build venv  ## pytest
	$(pytest) -n $(or $(WORKERS),4)

lint-python: venv  ## ruff
	$(bin)/ruff check
	$(bin)/ruff format --check

types: build venv  ## mypy, and the stub of the extension against the real thing
	$(bin)/python -m mypy
	$(bin)/python -m mypy.stubtest beltsort._core

stubs: build  ## the docstrings of the extension into its stubs
	$(bin)/python scripts/stub_docstrings.py
	$(bin)/ruff format beltsort

# Everything is read again: Sphinx forgets the warnings of a page that has not changed. In one process: Sphinx
# hangs where one of several meets an error.
docs: build venv  ## the documentation's site, docs/_build/html/index.html
	$(bin)/python -m sphinx --builder html --fresh-env --fail-on-warning --keep-going --quiet \
		--doctree-dir docs/_build/doctrees docs docs/_build/html

laws: SEED := $(shell od -An -N4 -tu4 /dev/urandom | tr -d ' ')
laws: build venv  ## the laws on ten times the cases, new ones each time; SEED=... for the same again
	BELTSORT_LAWS=1 PROPTEST_RNG_SEED=$(SEED) cargo test -p beltsort-core
	BELTSORT_LAWS=1 $(bin)/python -m pytest -m hypothesis --hypothesis-seed=$(SEED)

soak: build venv  ## 100 kills, 1,000 objects with faults, 3,000 sequences of faults, a peer of ROS 2 in Rust; an hour
	$(bin)/python -m pytest tests/soak tests/second tests/contract/test_diversions.py tests/cli/test_service_soak.py -m soak -s

bench: build venv  ## criterion and pytest-benchmark; on an idle machine
	cargo bench -p beltsort-benches
	$(bin)/python -m pytest benchmarks --benchmark-enable
	$(bin)/python -m benchmarks.machine
	$(bin)/python -m benchmarks.machine perception

format: venv  ## format everything, and mend what ruff can mend
	cargo fmt --all
	$(bin)/ruff check --fix
	$(bin)/ruff format

wheel: venv  ## dist/*.whl
	$(bin)/maturin build --out dist

clean:  ## remove everything made by this file (runs/ stays)
	rm -rf .venv target dist docs/_build docs/api/generated docs/commands beltsort/_core.abi3.so .mypy_cache .pytest_cache .ruff_cache

# scripts/bootstrap touches .venv/installed only when packages or metadata have changed: editing the settings of a tool
# in pyproject.toml installs and builds nothing.
.venv/ready: pyproject.toml scripts/bootstrap scripts/debian-packages.txt scripts/ros2-packages.txt
	bash scripts/bootstrap
	@touch $@

.venv/dev-ready: .venv/ready
	bash scripts/bootstrap dev
	@touch $@

.venv/installed: .venv/ready ;

# One extension is installed at a time. -any is what `make check` needs: either, as long as it is up to date.
.venv/extension-release: .venv/installed $(rust_sources)
	$(bin)/maturin develop --profile release
	@rm -f .venv/extension-dev
	@touch $@ .venv/extension-any

.venv/extension-dev: .venv/installed $(rust_sources)
	$(bin)/maturin develop --profile dev
	@rm -f .venv/extension-release
	@touch $@ .venv/extension-any

.venv/extension-any: .venv/installed $(rust_sources)
	$(MAKE) dev

.venv/checked-rust: clippy.toml rustfmt.toml $(rust_sources) | venv
	cargo fmt --all --check
	cargo clippy --workspace --all-targets -- -D warnings
	cargo test
	@touch $@
