"""Speed of the simulator and of the fit, beside others in one process. Prints ratios; run by `make bench`."""

from __future__ import annotations

import argparse
import json
import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import tanh
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).parents[1]))

from long_log import bench_long_log
from support.paper_joint import RATIO, SAMPLING_TIME, STRUCTURE, TRUTH, references
from support.paths import ROOT

from robotid.catalogue import assemble
from robotid.config.load import load
from robotid.config.schema import DiagnoseSettings
from robotid.diagnosis.noise.whitening import UNIT_WHITENING, Segment
from robotid.diagnosis.refit.refit import unknowns_of
from robotid.diagnosis.refit.refitted_model import segment_fit
from robotid.diagnosis.scoring.catalogue_candidates import candidates
from robotid.diagnosis.scoring.projection import project
from robotid.diagnosis.scoring.scan import scan, scans
from robotid.diagnosis.scoring.score_test import score
from robotid.estimate import lifted
from robotid.estimate.least_squares import SolveOptions, linearise, solve
from robotid.estimate.residual import OutputError
from robotid.model.array import Array
from robotid.parallel import working
from robotid.pipeline.execute import execute
from robotid.pipeline.run import Run
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.signals.stretches import stretches
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from robotid.simulation.simulate import simulate

LONG = 400_000  # samples; 7,200,000 are an hour at 2 kHz, and take an hour

M0 = {
    "motor.inertia.J": 0.0123,
    "motor.viscous.Fv": 0.0136,
    "motor.coulomb.Fc": 0.642,
    "gear.spring.k1": 0.814e6,
    "gear.cubic_spring.k3": 5.4e10,
    "gear.damper.d": 0.0,
    "arm.inertia.J": 790.0,
}


def records() -> tuple[Record, ...]:
    """The paper's three sets from the virtual robot."""
    joint = assemble(STRUCTURE, angle=True)
    theta = joint.parameters().with_values(TRUTH).values
    plant = VirtualRobot(joint, theta, Controller("speed", kp=0.3, ki=3.0), 1e-5, 0.005, 0.02, seed=1)
    made = (Reference(f"set{k + 1}", SAMPLING_TIME, ref, "speed") for k, ref in enumerate(references()))
    return tuple(plant.record(reference, k) for k, reference in enumerate(made))


def clock(run: Callable[[], object], times: int = 3) -> float:
    """Least wall time of several runs [s]."""
    taken = []
    for _ in range(times):
        begin = time.perf_counter()
        run()
        taken.append(time.perf_counter() - begin)
    return min(taken)


def ours(data: tuple[Record, ...]) -> OutputError:
    joint = assemble(STRUCTURE)
    return OutputError(joint, joint.parameters().with_values(M0), data, "speed", np.ones(len(data)))


class CasadiGaussNewton:
    """Gauss-Newton with step halving on CasADi's exact Jacobian of a Runge-Kutta 4 simulation, one step a sample."""

    def __init__(self, data: tuple[Record, ...]) -> None:
        import casadi as ca

        self.data, self.functions = data, {}
        for n in {len(record) for record in data}:
            x, u, q = ca.SX.sym("x", 3), ca.SX.sym("u"), ca.SX.sym("q", 7)

            def rate(x: ca.SX, u: ca.SX = u, q: ca.SX = q) -> ca.SX:
                jm, fv, fc, k1, k3, d, ja = (q[i] for i in range(7))
                slip = RATIO * x[1] - x[2]
                gear = k1 * x[0] + k3 * x[0] ** 3 + d * slip
                return ca.vertcat(slip, (u - fv * x[1] - fc * ca.tanh(x[1] / 0.02) - RATIO * gear) / jm, gear / ja)

            h = SAMPLING_TIME
            a = rate(x)
            b = rate(x + h / 2 * a)
            c = rate(x + h / 2 * b)
            d = rate(x + h * c)
            step = ca.Function("step", [x, u, q], [x + h / 6 * (a + 2 * b + 2 * c + d)])
            x0, theta, torque = ca.MX.sym("x0", 3), ca.MX.sym("q", 7), ca.MX.sym("u", 1, n - 1)
            states = step.mapaccum(n - 1)(x0, torque, ca.repmat(theta, 1, n - 1))
            y = ca.horzcat(x0, states)[1, :].T
            self.functions[n] = (
                ca.Function("y", [theta, x0, torque], [y]),
                ca.Function("j", [theta, x0, torque], [y, ca.jacobian(y, ca.vertcat(theta, x0))]),
            )

    def residual(self, z: Array, k: int) -> Array:
        record = self.data[k]
        y = self.functions[len(record)][0](z[:7], z[7 + 3 * k : 10 + 3 * k], record.tau_m[None, :-1])
        return record.dphi_m - np.array(y)[:, 0]

    def cost(self, z: Array) -> float:
        return 0.5 * sum(float(r @ r) for r in (self.residual(z, k) for k in range(len(self.data))))

    def fit(self, z: Array) -> tuple[Array, int]:
        for iteration in range(1, 40):
            normal, gradient, cost = np.zeros((len(z), len(z))), np.zeros(len(z)), 0.0
            for k, record in enumerate(self.data):
                where = np.r_[0:7, 7 + 3 * k : 10 + 3 * k]
                y, j = self.functions[len(record)][1](z[:7], z[where[7:]], record.tau_m[None, :-1])
                r, jacobian = record.dphi_m - np.array(y)[:, 0], np.array(j)
                normal[np.ix_(where, where)] += jacobian.T @ jacobian
                gradient[where] += jacobian.T @ r
                cost += 0.5 * float(r @ r)
            scale = np.sqrt(np.diag(normal))
            step = np.linalg.solve(normal / np.outer(scale, scale), gradient / scale) / scale
            share = 1.0
            while share > 1e-3 and self.cost(z + share * step) >= cost:
                share /= 2
            z = z + share * step
            if cost - self.cost(z) < 1e-6 * cost:
                return z, iteration
        return z, iteration


def scipy_fit(data: tuple[Record, ...], start: Array) -> tuple[Array, int]:
    """least_squares with finite differences on solve_ivp: parameters found, and simulations of all records."""

    def speeds(theta: Array, x0: Array, record: Record) -> Array:
        jm, fv, fc, k1, k3, d, ja = theta.tolist()
        u, h = record.tau_m.tolist(), record.sampling_time

        def rate(t: float, x: Array) -> list[float]:
            twist, wm, wa = x.tolist()
            slip = RATIO * wm - wa
            gear = k1 * twist + k3 * twist**3 + d * slip
            torque = u[min(int(t / h), len(u) - 1)]
            return [slip, (torque - fv * wm - fc * tanh(wm / 0.02) - RATIO * gear) / jm, gear / ja]

        return np.asarray(
            solve_ivp(rate, (0, record.t[-1]), x0, t_eval=record.t, max_step=h, rtol=1e-6, atol=1e-9).y[1]
        )

    def residual(z: Array) -> Array:
        return np.concatenate([r.dphi_m - speeds(z[:7], z[7 + 3 * k : 10 + 3 * k], r) for k, r in enumerate(data)])

    typical = np.concatenate([np.array(list(TRUTH.values())), np.tile([1e-4, 1.0, 1e-2], len(data))])
    found = least_squares(lambda z: residual(z * typical), start / typical, diff_step=1e-4, ftol=1e-6)
    return found.x * typical, found.nfev + len(start) * found.njev


def long_record(n: int) -> Record:
    t = np.arange(n) * SAMPLING_TIME
    u = 2.0 * np.sin(2 * np.pi * 1.3 * t) + 2 * np.sin(2 * np.pi * 7 * t + 1)
    joint = assemble(STRUCTURE)
    short = Record("long", "estimate", "both", SAMPLING_TIME, u, 0 * u, 0 * u)
    speed = simulate(joint, joint.parameters().with_values(TRUTH).values, short, np.zeros(3)).dphi_m
    return replace(short, dphi_m=speed + 0.02 * np.random.default_rng(0).standard_normal(n))


def bench_fit(with_scipy: bool) -> dict[str, float]:
    """The fit as `fit` does it, beside others. Returns how many times CasADi's speed it has, and CasADi's time [s]."""
    data = records()
    problem = ours(data)
    start = problem.start()
    print(f"a fit of {sum(map(len, data))} samples, 7 parameters and 9 initial states, from m0")
    solution = lifted.solve(problem, start, SolveOptions(tolerance=1e-6))
    theta = solution.evaluation.unknowns[:7]
    print(f"  robotid  {len(solution.cost) - 1} iterations, {solution.end}, worst error {worst(theta):.2%}")
    rival = CasadiGaussNewton(data)
    z, iterations = rival.fit(start)
    print(f"  CasADi   {iterations} iterations, worst error {worst(z[:7]):.2%}")
    mine, casadi = (
        clock(lambda: lifted.solve(problem, start, SolveOptions(tolerance=1e-6))),
        clock(lambda: rival.fit(start)),
    )
    print(f"  robotid {mine:.2f} s, Gauss-Newton on CasADi's Jacobian {casadi:.2f} s: {casadi / mine:.2f} times faster")
    every = clock(lambda: solve(problem, start, SolveOptions(tolerance=1e-6)))
    print(f"  simulating at every iterate {every:.2f} s")
    if with_scipy:
        begin = time.perf_counter()
        z, simulations = scipy_fit(data, start)
        theirs = time.perf_counter() - begin
        print(f"  least_squares on solve_ivp: {simulations} simulations, worst error {worst(z[:7]):.2%}")
        print(f"  robotid {mine:.2f} s, least_squares on solve_ivp {theirs:.0f} s: {theirs / mine:.0f} times faster")
    return {"fit.times_casadi": casadi / mine, "casadi.seconds": casadi}


def worst(theta: Array) -> float:
    """Largest relative error but that of k3, which these records hardly see."""
    truth = np.array(list(TRUTH.values()))
    return float(np.delete(np.abs(theta / truth - 1), 4).max())


def bench_length() -> dict[str, float]:
    """Returns what the longest record costs."""
    print("simulation, and simulation with Jacobian, against the number of samples")
    for n in (20_000, 200_000, 2_000_000):
        record = long_record(n)
        problem = OutputError(
            assemble(STRUCTURE), assemble(STRUCTURE).parameters().with_values(TRUTH), (record,), "speed", np.ones(1)
        )
        start = problem.start()
        begin = time.perf_counter()
        at = problem.evaluate(start)
        middle = time.perf_counter()
        linearise(problem, at)
        end = time.perf_counter()
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        print(
            f"  {n:>9} samples: {1e6 * (middle - begin) / n:.2f} us a sample,"
            f" with Jacobian {1e6 * (end - begin) / n:.2f} us, peak memory so far {peak:.2f} GB"
        )
    return {"simulation.us_per_sample": 1e6 * (middle - begin) / n, "simulation.gb": peak}


def bench_catalogue() -> dict[str, float]:
    """All candidates with their grids scored once on the paper's records. Returns its time in simulations of these."""
    data = records()
    problem = replace(ours(data), parameters=ours(data).joint.parameters().with_values(TRUTH))
    at = problem.evaluate(problem.start())
    missing = candidates(problem.joint.structure, "speed")
    segments = [segment_fit(Segment(r, UNIT_WHITENING), t, "speed") for r, t in zip(data, at.trajectories, strict=True)]

    def run() -> None:
        score(project(scans(segments, unknowns_of(problem), missing)), missing)

    begin = time.process_time()
    wall = clock(run)
    cpu = (time.process_time() - begin) / 3
    simulation = clock(lambda: problem.evaluate(problem.start()))
    print(
        f"{len(missing)} candidates scored over {sum(map(len, data))} samples: {wall:.2f} s, processor {cpu:.2f} s,"
        f" {wall / simulation:.1f} simulations"
    )
    return {"catalogue.in_simulations": wall / simulation}


TWO_HIDDEN = (
    "plant.model={motor: [inertia, viscous, coulomb, stribeck, cogging],"
    " gear: [spring, cubic_spring, damper], arm: [inertia]}",
    "plant.parameters.motor.stribeck.dFs=0.2",
    "plant.parameters.motor.stribeck.vs=2",
    "plant.parameters.motor.cogging.A=0.03",
    "plant.parameters.motor.cogging.B=0.02",
    "plant.parameters.motor.cogging.n=6",
)


def bench_diagnosis() -> dict[str, float]:
    """Diagnosis and extension of the paper's experiment, 32,500 samples, with two effects hidden in the plant. Returns
    the time of both together [s]."""
    return {"diagnose_extend.seconds": sum(timed("paper.yaml", TWO_HIDDEN).values())}


def timed(config: str, overrides: Sequence[str] = ()) -> dict[str, float]:
    """Wall times [s] of the diagnosis and the extension of a configuration."""
    taken = {}
    with tempfile.TemporaryDirectory() as folder:
        run = Run(load(ROOT / "configs" / config, overrides), Path(folder))
        before = ("excite",) if any(record.excite is not None for record in run.loaded.config.records) else ()
        for stage in (*before, "collect", "init-rigid", "init-flex", "fit"):
            execute(run, stage)
        for stage in ("diagnose", "extend"):
            begin, busy = time.perf_counter(), time.process_time()
            content = execute(run, stage).content
            taken[stage], cpu = time.perf_counter() - begin, time.process_time() - busy
            named = [c.effect for c in content.causes] if stage == "diagnose" else list(content.added)
            print(f"{stage} {config}: {', '.join(named) or 'nothing'} in {taken[stage]:.1f} s, processor {cpu:.1f} s")
    return taken


HARD_BACKLASH = (
    "plant.model={motor: [inertia, viscous, coulomb], gear: [spring, cubic_spring, damper, backlash], arm: [inertia]}",
    "plant.parameters.gear.backlash.gap=3e-4",
)


def bench_backlash() -> dict[str, float]:
    """Diagnosis of the paper's experiment on a gear with a hard backlash, which many crossings make slow [s]."""
    return {"backlash.seconds": timed("paper.yaml", HARD_BACKLASH)["diagnose"]}


def bench_kuka() -> dict[str, float]:
    """Diagnosis and extension of a real robot's axis [s], empty where its recordings are not there."""
    config = load(ROOT / "configs" / "kuka_axis1.yaml")
    missing = [f for r in config.config.records for f in r.files if not (config.directory / f).exists()]
    if missing:
        print(f"kuka_axis1.yaml is left out: there is no {missing[0]}")
        return {}
    return {"kuka.seconds": sum(timed("kuka_axis1.yaml").values())}


def bench_jobs() -> dict[str, float]:
    """Returns how much faster a diagnosis of the paper's experiment is on all cores than on one."""
    taken = {}
    with tempfile.TemporaryDirectory() as folder:
        run = Run(load(ROOT / "configs" / "paper.yaml", TWO_HIDDEN), Path(folder))
        for stage in ("excite", "collect", "init-rigid", "init-flex", "fit"):
            execute(run, stage)
        for jobs in (1, None):
            with working(jobs):
                begin = time.perf_counter()
                execute(run, "diagnose", force=True)
                taken[jobs] = time.perf_counter() - begin
    one, all_cores = taken[1], taken[None]
    cores = len(os.sched_getaffinity(0))
    print(f"diagnosis with one job {one:.1f} s, on {cores} cores {all_cores:.1f} s: {one / all_cores:.2f} times faster")
    return {"jobs.speedup": one / all_cores, "jobs.cores": float(cores)}


def bench_memory(n: int = 1_000_000) -> None:
    """Scoring a record of a million samples, in the stretches that a diagnosis looks at."""
    whole = long_record(n)
    parts = stretches(whole, DiagnoseSettings().samples)
    problem = replace(ours(tuple(parts)), parameters=ours(tuple(parts)).joint.parameters().with_values(TRUTH))
    at = problem.evaluate(problem.start())
    missing = candidates(problem.joint.structure, "speed")
    for record, trajectory in zip(parts, at.trajectories, strict=True):
        scan(segment_fit(Segment(record, UNIT_WHITENING), trajectory, "speed"), unknowns_of(problem), missing)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    looked = sum(map(len, parts))
    print(f"catalogue over {n} samples: {looked} looked at, peak memory so far {peak:.2f} GB")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--skip-scipy", action="store_true", help="leave out the slow comparison with plain SciPy")
    parser.add_argument("--skip-backlash", action="store_true", help="leave out the diagnosis of a hard backlash")
    parser.add_argument("--long", type=int, default=LONG, metavar="N", help=f"samples of the long log ({LONG})")
    parser.add_argument("--json", type=Path, help="a file for the figures: ratios, and seconds of this machine")
    options = parser.parse_args()
    bench_memory()
    found = bench_length() | bench_catalogue() | bench_diagnosis() | bench_jobs() | bench_fit(not options.skip_scipy)
    found |= bench_kuka() | (bench_backlash() if not options.skip_backlash else {}) | bench_long_log(options.long)
    for name in ("diagnose_extend", "kuka", "backlash"):
        if f"{name}.seconds" in found:
            ratio = found[f"{name}.in_casadi_fits"] = found[f"{name}.seconds"] / found["casadi.seconds"]
            print(f"{name}: {ratio:.1f} fits of CasADi's Gauss-Newton")
    if options.json is not None:
        options.json.write_text(json.dumps(found, indent=2) + "\n")
