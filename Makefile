# `make demo` and `make test` do all set-up on a fresh machine with Python 3.11; everything stays in .venv.
# `make campaign CAMPAIGN='--draws 500 --own-draws 100 --truths 100 --long-truths 20'` is a short one.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin
STAMP := .venv/.installed
# Where nothing compiled is kept, as many containers ask for, each process of a daemon compiles all sources anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: night resume-kills schedules-proof interlock trend-alarms soak crash write-kills install kernels demo demo-emulated test test-long check bench peers campaign attack attack-api fault-campaign wiring-campaign emulated-series accuracy diagnose-study angle-study clean

install: $(STAMP)

$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; assert sys.version_info[:2] == (3, 11), f"Python 3.11 is needed, this is {sys.version.split()[0]}; run make with PYTHON=/path/to/python3.11"'
	@echo 'Everything is installed into .venv; nothing outside this folder is changed.'
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	$(MAKE) --silent kernels
	touch $@
	@echo 'Installed. Now `make demo`, or `. .venv/bin/activate` and `platform-daemon --help`.'

# The first fit on a computer compiles; here it is seen, and waited for once.
kernels:
	@echo 'Compiling the numerical kernels, once ...'
	$(BIN)/python -c 'from platform_daemon.estimation import warm_up; print(f"... in {warm_up():.0f} s")'

demo: install
	$(BIN)/python demo/run.py

demo-emulated: install
	$(BIN)/python demo/run.py --emulated

test: install
	$(BIN)/pytest

# The tests that `make test` has no time for: daemons that die and start, short campaigns, long diagnoses.
test-long: install
	$(BIN)/pytest -m long

check: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

campaign: install
	HYPOTHESIS_PROFILE=campaign $(BIN)/pytest -m campaign -s
	$(BIN)/python -m tests.campaigns.estimator_statistics $(CAMPAIGN)

# A crowd against one daemon, five minutes; `make attack ATTACK='--seconds 3 --rx-s 5 --shots 20'` is a short one.
attack: install
	$(BIN)/python -m tests.campaigns.attack.campaign --page docs/attack.md $(ATTACK)

# `make attack-api CASES=10` is a short one.
CASES ?= 100
attack-api: install
	$(BIN)/python -m tests.campaigns.attack_api --cases $(CASES)

bench: install
	$(BIN)/python -m tests.benchmarks

# The tools of others go into .venv as well, half a GB; nothing else needs them. sysidentpy asks for a numpy older than
# ours and runs with ours, so it comes without its dependencies. `make peers PEERS='--only r1'` is a short one.
peers: install .venv/.peers
	$(BIN)/python -m tests.benchmarks.peers $(PEERS)

.venv/.peers: $(STAMP) constraints-peers.txt
	$(BIN)/pip install --disable-pip-version-check --constraint constraints.txt --constraint constraints-peers.txt --editable '.[dev,peers]'
	$(BIN)/pip install --disable-pip-version-check --constraint constraints-peers.txt --no-deps sysidentpy
	touch $@

# `make diagnose-study STUDY='--sigma 15 --poses "as mounted"'` is a short one.
diagnose-study: install
	$(BIN)/python -m tests.campaigns.diagnosis_study $(STUDY)

# Deaths, hangs, cut links; `make crash CRASH='--each 1'` is a short one; the journal lets an interrupted one go on, with as many `--lanes`.
crash: install
	$(BIN)/python -m tests.campaigns.crash --page docs/crash.md $(CRASH)

# Ten simulated years of schedules, and deaths; `make schedules-proof PROOF='--years 1 --kills 50 --daemon-kills 5'` is a short one.
schedules-proof: install
	$(BIN)/python -m tests.campaigns.schedules_proof --page docs/schedules-proof.md $(PROOF)

# Scheduled series on the emulated wires with faults; `make night NIGHT='--minutes 3'` is a short one.
night: install
	$(BIN)/python -m tests.campaigns.night --page docs/night.md $(NIGHT)

# Random commands, faults and deaths; `make interlock INTERLOCK='--steps 10000'` is a short one.
interlock: install
	$(BIN)/python -m tests.campaigns.interlock --page docs/interlock.md $(INTERLOCK)

# Kills inside the write path; `make write-kills KILLS=400` is a short one.
KILLS ?= 1000
write-kills: install
	$(BIN)/python -m tests.campaigns.write_kills --kills $(KILLS) --page docs/write-kills.md

# Series that are cut off and resumed; `make resume-kills CUTS=10` is a short one.
CUTS ?= 200
resume-kills: install
	$(BIN)/python -m tests.campaigns.resume_kills --kills $(CUTS) --page docs/resume-kills.md

# Half years of specimens; `make trend-alarms YEARS=10` is a short one.
YEARS ?= 200
trend-alarms: install
	$(BIN)/python -m tests.campaigns.trend_alarms --years $(YEARS) --page docs/trend-alarms.md

# Scheduled series with listeners; `make soak SOAK='--shots 1000'` is a short one.
soak: install
	$(BIN)/python -m tests.campaigns.soak --page docs/soak.md $(SOAK)

# Angle records made by scipy; `make angle-study ANGLES='--records 32'` is a short one.
angle-study: install
	$(BIN)/python -m tests.campaigns.angle_study --page docs/angle-study.md --journal angle-study.jsonl $(ANGLES)

# `make fault-campaign FAULTS='--only "switch RX"'` is a short one; the journal lets an interrupted one go on.
fault-campaign: install
	$(BIN)/python -m tests.campaigns.faults.campaign --page docs/fault-campaign.md $(FAULTS)

# `make wiring-campaign BLOWS='--blows 40'` is a short one; the journal lets an interrupted one go on.
wiring-campaign: install
	$(BIN)/python -m tests.campaigns.faults.wiring_campaign --page docs/wiring-campaign.md $(BLOWS)

# Needs a quiet computer: it measures milliseconds between shots.
emulated-series: install
	$(BIN)/python -m tests.campaigns.emulated_series --page docs/emulated-series.md
	$(BIN)/python -m tests.benchmarks.reading_cpu

accuracy: install
	$(BIN)/python -m tests.campaigns.accuracy

clean:
	rm -rf .venv build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
