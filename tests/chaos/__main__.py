"""`make chaos`: kills, damaged files, forged artifacts and bad inputs until all counts or ten minutes are reached, and
what did not hold.

Two processes kill runs, then two damage and forge files: more would only wait for each other.
"""

from __future__ import annotations

import argparse
import random
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from support.paths import ROOT

from chaos.forgeries import COMMANDS, drawn, wrong_with
from chaos.kills import COLD, completion, configuration, duration, kill, moment
from chaos.mutations import complaint, mutated, subjects

KILLS, MUTATIONS, FORGERIES, SECONDS = 200, 10_000, 600, 600.0
AT_ONCE = 2
SHARE = 0.5  # of the time that the kills may take
FORGED = 0.8  # of the time after which damage must be done, and forging begins
READ = 10  # forged artifacts, of which one is read by every command and the others are loaded and shown
COMPLETE_EVERY = 10  # kills, after which the run directory is completed and begun anew
BAD_INPUTS = ("tests/integration/test_bad_data.py", "tests/integration/test_bad_config.py")


@dataclass(frozen=True, slots=True)
class Task:
    """What one worker does. folder : its own, where nobody else writes; run : a finished run directory; end : of the
    time that it has, as time.time() counts."""

    folder: Path
    config: Path
    run: Path
    count: int
    seed: int
    end: float


@dataclass(frozen=True, slots=True)
class Result:
    """How much was tried, and what did not hold."""

    tried: int
    wrong: tuple[str, ...]


def main() -> int:
    """Exit code 1 where anything did not hold, or less was tried than asked for."""
    parser = argparse.ArgumentParser(prog="python -m chaos", description=__doc__)
    parser.add_argument("--seed", type=int, default=16)
    parser.add_argument("--kills", type=int, default=KILLS)
    parser.add_argument("--mutations", type=int, default=MUTATIONS)
    parser.add_argument("--forgeries", type=int, default=FORGERIES)
    parser.add_argument("--seconds", type=float, default=SECONDS)
    chosen = parser.parse_args()
    begin = time.time()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        config, run = configuration(folder), folder / "run"
        whole = duration(config, run)
        print(f"seed {chosen.seed}, a whole run takes {whole:.1f} s besides its imports", flush=True)
        wrong = _bad_inputs()
        tasks = _tasks(folder, config, run, chosen.kills, chosen.seed, begin + SHARE * chosen.seconds)
        with ProcessPoolExecutor(AT_ONCE) as pool:
            kills = list(pool.map(_kills, tasks))
        print(f"{sum(k.tried for k in kills)} kills by {time.time() - begin:.0f} s", flush=True)
        tasks = _tasks(folder, config, run, chosen.mutations, chosen.seed + AT_ONCE, begin + FORGED * chosen.seconds)
        with ProcessPoolExecutor(AT_ONCE) as pool:
            damaged = list(pool.map(_mutations, tasks))
        tasks = _tasks(folder, config, run, chosen.forgeries, chosen.seed + 2 * AT_ONCE, begin + chosen.seconds)
        with ProcessPoolExecutor(AT_ONCE) as pool:
            forged = list(pool.map(_forgeries, tasks))
    wrong += [line for one in (*kills, *damaged, *forged) for line in one.wrong]
    print(*wrong, sep="\n", end="\n" if wrong else "")
    tried = [sum(one.tried for one in group) for group in (kills, damaged, forged)]
    seconds = time.time() - begin
    print("{} kills, {} damaged files, {} forged artifacts".format(*tried), f"in {seconds:.0f} s: {len(wrong)} failed")
    asked = (chosen.kills, chosen.mutations, chosen.forgeries)
    return int(bool(wrong) or any(done < wanted for done, wanted in zip(tried, asked, strict=True)))


def _tasks(folder: Path, config: Path, run: Path, count: int, seed: int, end: float) -> list[Task]:
    """So many tries on so many workers."""
    shares = [count // AT_ONCE + (k < count % AT_ONCE) for k in range(AT_ONCE)]
    return [Task(folder / f"seed{seed + k}", config, run, share, seed + k, end) for k, share in enumerate(shares)]


def _bad_inputs() -> list[str]:
    """What of the bad inputs does not hold."""
    command = [sys.executable, "-m", "pytest", "-q", "--tb=line", "-p", "no:cacheprovider"]
    started = [
        subprocess.Popen([*command, file], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        for file in BAD_INPUTS
    ]
    wrong = []
    for file, process in zip(BAD_INPUTS, started, strict=True):
        lines = process.communicate()[0].strip().splitlines() or [""]
        print(f"{file}: {lines[-1]}", flush=True)
        if process.returncode:
            wrong += [line for line in lines if line.startswith("FAILED")] or lines[-1:]
    return wrong


def _kills(task: Task) -> Result:
    """A run directory is completed once in a while, which counts as no try."""
    rng, wrong, tried = random.Random(task.seed), [], 0
    run, whole = task.folder / "killed", duration(task.config, task.folder / "whole")
    while tried < task.count and time.time() < task.end:
        cold = tried % COLD == 0
        number, after = moment(rng, whole, cold=cold)
        made = kill(task.config, run, number, after, cold=cold)
        wrong += [f"kill by {number.name} after {after:.3f} s (seed {task.seed}): {text}" for text in made.wrong]
        tried += 1
        if tried % COMPLETE_EVERY == 0 or tried == task.count:
            wrong += [f"completion after kill {tried} (seed {task.seed}): {x}" for x in completion(task.config, run)]
            shutil.rmtree(run, ignore_errors=True)
    return Result(tried, tuple(wrong))


def _mutations(task: Task) -> Result:
    rng, wrong, tried = random.Random(task.seed), [], 0
    task.folder.mkdir(exist_ok=True)
    made = subjects(task.folder, task.run)
    whole = {subject.file: subject.file.read_bytes() for subject in made}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        while tried < task.count and time.time() < task.end:
            subject = made[tried % len(made)]
            text = complaint(subject, mutated(whole[subject.file], rng, binary=subject.binary))
            wrong += [f"damage {tried} of {subject.file.name} (seed {task.seed}): {text}"] if text else []
            tried += 1
            shutil.rmtree(task.folder / f"run-{subject.file.suffix[1:]}", ignore_errors=True)
    return Result(tried, tuple(wrong))


def _forgeries(task: Task) -> Result:
    wrong, tried = [], 0
    task.folder.mkdir(exist_ok=True)
    for forgery in drawn(task.run, random.Random(task.seed))[: task.count]:
        if time.time() > task.end:
            break
        commands = COMMANDS if tried % READ == 0 else COMMANDS[:1]
        _, text = wrong_with(forgery, task.config, task.run, task.folder, commands)
        wrong += [f"forged {forgery} (seed {task.seed}): {text}"] if text else []
        tried += 1
    return Result(tried, tuple(wrong))


if __name__ == "__main__":
    sys.exit(main())
