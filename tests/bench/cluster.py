"""Processor time of a sweep on local Dask workers against that on threads.

`python tests/bench/cluster.py [RUNS]` runs the hydraulic crane for 3 s with as many boom masses on
threads of this process, then by `dask scheduler` and two workers of one thread. It prints the
processor time of each process while the sweep goes on, and that of the start of the cluster apart:
a cluster is started once. Times are those of the system's accounts, so other work on the machine
moves them by caches and turbo alone.

With `--kill` one worker is killed, for good, when it has used a quarter of the processor time that
threads needed in all. The results have to be those of the threads, bit by bit.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

import bgc
from bgc.library import __path__ as library

_TICKS = os.sysconf("SC_CLK_TCK")
_SCENE = Path(library[0]) / "scenes" / "knuckle_boom_hydraulic.bg"
_OBSERVE = ("max(boom_pressure_a)", "rms(boom_pressure_b)")


def seconds_of(pid: int) -> float:
    """Processor time of a process and its ended children, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / _TICKS


def family(pid: int) -> dict[int, str]:
    """A process and all below it, with what they are."""
    found = {pid: Path(f"/proc/{pid}/cmdline").read_bytes().decode().replace("\0", " ")}
    for task in Path(f"/proc/{pid}/task").iterdir():
        for child in (task / "children").read_text().split():
            found |= family(int(child))
    return found


def sweep(runs: int, **options: object) -> tuple[float, float, np.ndarray]:
    """Sweep; return the processor time of this process, the time by the clock and the values."""
    model = bgc.compile(_SCENE)
    begin, clock = time.process_time(), time.monotonic()
    vary = {"crane.arm.boom.mass": np.linspace(900, 1100, runs)}
    found = model.sweep(vary, _OBSERVE, duration=3, **options)
    assert not found.failures
    return time.process_time() - begin, time.monotonic() - clock, found.values


def kill_after(process: subprocess.Popen[bytes], seconds: float) -> None:
    """Kill a process once it has used `seconds` of processor time beyond its present ones."""
    until = seconds_of(process.pid) + seconds

    def watch() -> None:
        while process.poll() is None and seconds_of(process.pid) < until:
            time.sleep(0.1)
        process.send_signal(signal.SIGKILL)
        print(f"killed {process.pid} after {seconds:.1f} s of processor time", flush=True)

    threading.Thread(target=watch, daemon=True).start()


def main(runs: int, kill: bool) -> None:
    """Measure both ways, after one sweep that fills the cache."""
    sweep(16)
    own, clock, values = sweep(runs)
    print(f"threads: {own:.1f} s of processor time, {clock:.1f} s by the clock")
    with tempfile.TemporaryDirectory() as folder:
        at = f"{folder}/scheduler.json"
        quiet = {
            "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
            "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "500ms",
            "DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL": "10s",
        }  # as the manual advises
        dask = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--scheduler-file", at]
        scheduler = subprocess.Popen(
            [*dask, "--no-dashboard", "--host", "127.0.0.1", "--port", "0"],
            stderr=subprocess.DEVNULL,
            env={**os.environ, **quiet},
        )
        while not (Path(at).exists() and Path(at).read_text()):
            time.sleep(0.2)
        address = json.loads(Path(at).read_text())["address"]
        dask = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-dashboard"]
        dask += ["--nthreads", "1", "--local-directory", folder]
        # A nanny would start a killed worker again.
        kinds = [["--no-nanny"], ["--no-nanny"]] if kill else [["--nworkers", "2"]]
        workers = [
            subprocess.Popen([*dask, *kind], stderr=subprocess.DEVNULL, env={**os.environ, **quiet})
            for kind in kinds
        ]
        try:
            time.sleep(20)  # until both have registered
            processes = family(scheduler.pid)
            for process in workers:
                processes |= family(process.pid)
            started = {pid: seconds_of(pid) for pid in processes}
            print(f"start of the cluster: {sum(started.values()):.1f} s", flush=True)
            if kill:
                kill_after(workers[0], own / 4)
            client, clock, again = sweep(runs, scheduler=address)
            if kill and workers[0].poll() is None:
                sys.exit("the sweep ended before its worker was killed: give more runs")
            ended = {pid: seconds_of(pid) for pid in processes if Path(f"/proc/{pid}").exists()}
        finally:
            for process in (*workers, scheduler):
                process.terminate()
            for process in (*workers, scheduler):
                process.wait(30)
    if not np.array_equal(values, again):
        sys.exit("the cluster's results are not those of threads")
    print(f"{runs} results are those of threads, bit by bit")
    total = client
    print(f"cluster, {clock:.1f} s by the clock: client {client:.1f} s")
    for pid, used in ended.items():
        total += used - started[pid]
        print(f"  {used - started[pid]:6.1f} s  {processes[pid][-60:]}")
    print(f"in all {total:.1f} s, {total / own:.2f} of the threads" * (not kill))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("runs", type=int, nargs="?", default=2000)
    parser.add_argument("--kill", action="store_true", help="kill a worker halfway")
    given = parser.parse_args()
    main(given.runs, given.kill)
