"""The command line: one file per command, and what the commands share.

bench: `platform-daemon bench fit`: kept for those who call it.
self_test: `platform-daemon self-test`: is the chain as the platform file says?
calibrate: `platform-daemon calibrate receive | transmit`.
design: `platform-daemon design | defects`: what a design says, and what manufacturing defects do to it.
devices: `platform-daemon devices | reset-amplifier | config check`.
diagnose: `platform-daemon diagnose`: what the declared model lacks, with proof by data that were not used.
diagnose_live: `platform-daemon diagnose --live`: measure, diagnose, run the proposed next measurement, diagnose
    again.
emulate: `platform-daemon emulate`: the lab's devices behind their real wires, for tests and for trying drivers.
fit: `platform-daemon fit`: one or many recordings, on all cores or on a cluster.
harmonics: `platform-daemon harmonics`: a second look at every frame, without a fit.
interrupts: Ctrl-C and SIGTERM of the commands: none is lost, and nothing disturbs the way out.
logs: Log events of the daemon on the terminal.
main: The command line: `platform-daemon serve | measure | fit | harmonics | slide | diagnose | plot | ...`.
measure: `platform-daemon measure`: a series of shots without a server.
models: `platform-daemon adopt | models`: models that a diagnosis has made better.
options: Options and small parts that several commands share.
output: Result files of the command line: never overwritten without --force, whole or not at all.
parsing: Words of the command line as values: windows, parameters, frames.
precision: `platform-daemon predict`: what a planned measurement can tell.
progress: Progress on the terminal, on stderr, so that standard output holds results only.
recordings: `platform-daemon info | plot`: what a recording holds.
serve: `platform-daemon serve`: the daemon with its REST interface.
sliding: `platform-daemon slide`: fits along one ring-down, window by window.
"""
