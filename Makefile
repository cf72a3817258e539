# make demo: the main job. make test: all checks. Both set up everything they need in .venv.
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt
PACKAGES := libegl1 libgl1-mesa-dri libgles2
REAL_TESTS := tests

.PHONY: demo test bench check system clean

demo: $(VENV)/.installed
	$(BIN)/affectsim demo --out demo

test: check
	$(BIN)/python -m pytest -q -n auto --maxprocesses 4 --dist loadfile $(REAL_TESTS)

check: $(VENV)/.installed-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy

bench: $(VENV)/.installed-dev
	$(BIN)/python -m benchmarks --out benchmarks/results

$(VENV)/.installed: pyproject.toml constraints.txt | system
	python3 -m venv $(VENV)
	$(PIP) -e .
	touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(PIP) -e '.[dev]'
	touch $@

# Headless OpenGL (and venv, which Debian packs apart), where apt is; else the one line to run.
system:
	@missing=""; \
	if command -v dpkg-query >/dev/null && command -v apt-get >/dev/null; then \
	  for package in $(PACKAGES); do \
	    dpkg-query -W -f '$${Status}' $$package 2>/dev/null | grep -q 'ok installed' \
	      || missing="$$missing $$package"; \
	  done; \
	  python3 -c 'import ensurepip' 2>/dev/null || missing="$$missing python3-venv"; \
	fi; \
	if [ -n "$$missing" ]; then \
	  if [ "$$(id -u)" = 0 ]; then \
	    apt-get update -qq && DEBIAN_FRONTEND=noninteractive \
	      apt-get install -y -qq --no-install-recommends $$missing >/dev/null; \
	  else \
	    echo "Missing system libraries. Run this once, then make again:"; \
	    echo "  sudo apt-get install -y$$missing"; \
	    case "$$missing" in *python3-venv*) exit 1;; esac; \
	  fi; \
	fi

clean:
	rm -rf $(VENV) build dist demo .mypy_cache .pytest_cache .ruff_cache
