"""A measured log of any length through every stage, each in a process of its own: peak memory and processor time.

Run by itself, `python tests/bench/long_log.py --samples 7200000`, it prints the table of an hour at 2 kHz.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from support.paper_joint import RATIO, SAMPLING_TIME, STRUCTURE, TRUTH
from support.paths import ROOT

from robotid.catalogue import assemble
from robotid.model.array import Array
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate

STAGES = ("collect", "check", "init-rigid", "init-flex", "fit", "validate", "diagnose", "extend", "report")
HIDDEN = {"motor.stribeck.dFs": 0.2, "motor.stribeck.vs": 2.0}
CHUNK = 200_000  # samples simulated at once
QUANTUM = 2 * np.pi / 65536  # rad, of the encoder
TORQUE_NOISE, SPEED_NOISE = 0.005, 0.02  # Nm, rad/s
CONFIG = f"""
robot:
  name: long
  gear_ratio: {RATIO}
  model:
    motor: [inertia, viscous, coulomb]
    gear: [spring, cubic_spring, damper]
    arm: [inertia]
records:
  - {{name: long, file: long.npz, columns: &columns {{t: time, tau_m: torque, phi_m: angle, dphi_m: speed}}}}
  - {{name: check, role: validate, file: check.npz, columns: *columns}}
init_flex: {{band: [1, 40]}}
"""
MEASURED = """
import json, sys, time
from robotid.cli.app import main
code = main(sys.argv[1:])
with open("/proc/self/status", encoding="ascii") as facts:
    peak = next(int(line.split()[1]) for line in facts if line.startswith("VmHWM:"))
print(json.dumps({"code": code, "seconds": time.process_time(), "gb": peak / 1e6}))
"""


@dataclass(frozen=True, slots=True)
class Cost:
    """Of one stage: processor time [s] and peak resident memory [GB]."""

    seconds: float
    gb: float


def log_signals(samples: int, seed: int) -> dict[str, Array]:
    """A log of the paper's joint with a Stribeck effect: time, torque, angle and speed as a drive has them, (n,)."""
    rng, n_lines = np.random.default_rng(seed), 40
    frequency = np.arange(1, n_lines + 1) + rng.uniform(-0.3, 0.3, n_lines)
    phase = rng.uniform(0, 2 * np.pi, n_lines)
    joint = assemble(replace(STRUCTURE, terms=(*STRUCTURE.terms, "motor.stribeck")), angle=True)
    theta = joint.parameters().with_values(TRUTH | HIDDEN).values
    state, parts = np.zeros(joint.nx), []
    for first in range(0, samples, CHUNK):
        count = min(CHUNK, samples - first)
        t = (first + np.arange(count + 1)) * SAMPLING_TIME
        u = 2.0 * np.sin(2 * np.pi * 0.41 * t) + 2.0 * np.sin(2 * np.pi * 7.3 * t + 1.0)
        for f, p in zip(frequency, phase, strict=True):
            u += 0.25 * np.sin(2 * np.pi * f * t + p)
        motion = simulate(joint, theta, Record("log", "estimate", "both", SAMPLING_TIME, u, 0 * u, 0 * u), state)
        state = motion.x[:, -1]
        noisy = u[:-1] + TORQUE_NOISE * rng.standard_normal(count)
        speed = motion.dphi_m[:-1] + SPEED_NOISE * rng.standard_normal(count)
        parts.append((np.round(t[:-1], 6), noisy, QUANTUM * np.round(motion.phi_m[:-1] / QUANTUM), speed))
    columns = (np.concatenate(part) for part in zip(*parts, strict=True))
    return dict(zip(("time", "torque", "angle", "speed"), columns, strict=True))


def write_log(folder: Path, samples: int) -> Path:
    """The log, another of an eighth of its length to validate on, and the configuration, whose path is returned."""
    for name, n, seed in (("long", samples, 0), ("check", max(20_000, samples // 8), 1)):
        np.savez(folder / f"{name}.npz", **log_signals(n, seed))  # type: ignore[arg-type]
    config = folder / "long.yaml"
    config.write_text(CONFIG, encoding="utf-8")
    return config


def stage_costs(config: Path, out: Path) -> dict[str, Cost]:
    """The cost of every stage. Raises RuntimeError where one fails."""
    found = {}
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    for stage in STAGES:
        call = [sys.executable, "-c", MEASURED, stage, str(config), "--out", str(out), "--quiet", "--jobs", "1"]
        call = call[: -2 if stage == "check" else None]
        done = subprocess.run(call, capture_output=True, text=True, env=environment, check=False)
        facts: Mapping[str, float] = json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else {"code": 1}
        if facts["code"] != 0:
            raise RuntimeError(f"{stage} of the long log fails: {done.stderr[-2000:]}")
        found[stage] = Cost(facts["seconds"], facts["gb"])
        size = sum(file.stat().st_size for file in out.iterdir()) / 1e6
        print(f"  {stage:<11}{facts['seconds']:8.1f} s {facts['gb']:6.2f} GB, run directory {size:.1f} MB", flush=True)
    return found


def bench_long_log(samples: int) -> dict[str, float]:
    """Peak memory over the stages, and the processor time of all of them for a sample."""
    print(f"a log of {samples} samples and one of an eighth of it through every stage")
    with tempfile.TemporaryDirectory() as folder:
        config = write_log(Path(folder), samples)
        costs = stage_costs(config, Path(folder) / "run")
        page = (Path(folder) / "run" / "report.html").stat().st_size / 1e6
    peak, total = max(cost.gb for cost in costs.values()), sum(cost.seconds for cost in costs.values())
    print(f"  peak memory {peak:.2f} GB, {1e6 * total / samples:.0f} us a sample, the page {page:.1f} MB")
    return {"long.samples": samples, "long.gb": peak, "long.us_per_sample": 1e6 * total / samples, "long.page_mb": page}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=7_200_000, help="of the log")
    bench_long_log(parser.parse_args().samples)
