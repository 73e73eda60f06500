"""What goes on while a stage works: a live line and a table of the fits on a terminal, plain lines elsewhere."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from robotid.cli.console import print_message
from robotid.numerals import duration, number
from robotid.progress import Begun, Log, Progress, Step

if TYPE_CHECKING:
    from rich.console import RenderableType

LINE_INTERVAL = 5.0  # [s] between plain lines of progress
MAX_SILENCE = 30.0  # [s] without any line, at most
MIN_WORK = 2.0  # [s] of work from which the time left is shown


@contextmanager
def watching(*, quiet: bool) -> Iterator[Log | None]:
    """A log for the events of stages; None where nothing is shown."""
    if quiet:
        yield None
    elif sys.stderr.isatty() and os.environ.get("TERM") not in ("dumb", "unknown", None):
        with _live() as log:
            yield log
    else:
        lines = _Lines()
        with _heartbeat(lines.beat):
            yield lines


class Watch:
    """How far a stage is, from its events. clock : seconds, of any origin."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.clock = clock
        self.update(Begun(""))

    def update(self, event: Begun | Progress | Step) -> None:
        """Take in an event."""
        if isinstance(event, Begun):
            self.stage, self.now = event.stage, Progress("")
            self.begun = self.counted = self.updated = self.clock()
            self.fits: dict[str, Step | None] = {}
        elif isinstance(event, Progress):
            self._count(event)
        else:
            self.fits = self.fits or dict.fromkeys(event.models)
            self.fits[event.model] = event
            self._count(Progress(event.model, event.models.index(event.model), len(event.models)))

    def _count(self, event: Progress) -> None:
        now = self.clock()
        if event.total != self.now.total or event.done < self.now.done:
            self.counted = self.updated = now
        elif event.done > self.now.done:
            self.updated = now
        self.now = event

    @property
    def elapsed(self) -> float:
        """Time since the stage began [s]."""
        return self.clock() - self.begun

    @property
    def left(self) -> float | None:
        """Time left of what is counted [s], at the pace so far; None where that is not known."""
        spent, since = self.updated - self.counted, self.clock() - self.updated
        if not self.now.done or spent + since < MIN_WORK:
            return None
        left = spent / self.now.done * (self.now.total - self.now.done) - since
        return left if left > 0 else None

    @property
    def percent(self) -> str:
        """What share is done, where that is known."""
        return f"{100 * self.now.done // self.now.total} %" if self.now.total else ""

    def line(self) -> str:
        """All of it in a line."""
        left = "" if self.left is None else f"about {duration(self.left)} left"
        facts = (self.now.label, self.percent and f"{self.percent} done", duration(self.elapsed), left)
        return f"{self.stage}: {', '.join(fact for fact in facts if fact)}"


@contextmanager
def _heartbeat(beat: Callable[[], None]) -> Iterator[None]:
    """Call a function every second from a thread of its own, for as long as the block lasts."""
    over = threading.Event()

    def run() -> None:
        while not over.wait(1.0):
            beat()

    thread = threading.Thread(target=run, name="progress", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


class _Lines:
    """Plain lines: every iteration of a fit, now and then how far a stage is, and never a long silence."""

    def __init__(self) -> None:
        self.watch = Watch()
        self.printed = self.watch.clock()

    def beat(self) -> None:
        """Print how far the stage is where nothing has been printed for long."""
        if self.watch.stage and self.watch.clock() - max(self.printed, self.watch.begun) >= MAX_SILENCE:
            self.printed = self.watch.clock()
            print_message(self.watch.line())

    def __call__(self, event: Begun | Progress | Step) -> None:
        self.watch.update(event)
        if isinstance(event, Step):
            self.printed = self.watch.clock()
            print_message(_line(event))
        elif isinstance(event, Progress) and self.watch.clock() - max(self.printed, self.watch.begun) > LINE_INTERVAL:
            self.printed = self.watch.clock()
            print_message(self.watch.line())


def _line(step: Step) -> str:
    i = step.iteration
    return f"{step.model}  iteration {i.number:3d}  cost {i.cost:.6e}  decrease {i.decrease:.1e}"


@contextmanager
def _live() -> Iterator[Log]:
    from rich.live import Live
    from rich.spinner import Spinner

    from robotid.cli.console import terminal

    console, watch = terminal(sys.stderr), Watch()
    spinner = Spinner("dots" if console.encoding.startswith("utf") else "line", style="cyan")
    with Live(
        console=console, transient=True, refresh_per_second=8, get_renderable=lambda: live_display(watch, spinner)
    ):
        yield watch.update


def live_display(watch: Watch, spinner: RenderableType) -> RenderableType:
    """The live display: of a fit the table of its models, and a line of how far the stage is."""
    from rich.console import Group
    from rich.progress_bar import ProgressBar
    from rich.table import Table as Grid
    from rich.text import Text

    if not watch.stage:
        return Text("")
    line = Grid.grid(padding=(0, 1))
    line.add_column(width=1)
    line.add_column(no_wrap=True)
    line.add_column()  # the only one that may shrink
    label = Text(watch.now.label, no_wrap=True, overflow="ellipsis")
    cells: list[RenderableType] = [spinner, Text(watch.stage, "bold"), label]
    if watch.now.total:
        cells += [ProgressBar(watch.now.total, watch.now.done, width=12), Text(watch.percent)]
    cells.append(Text(duration(watch.elapsed), "dim"))
    if watch.left is not None:
        cells.append(Text(f"{duration(watch.left)} left", "cyan"))
    for _ in cells[3:]:
        line.add_column(no_wrap=True, justify="right")
    line.add_row(*cells)
    return Group(_fits(watch.fits, watch.now.label), line) if watch.fits else line


def _fits(fits: dict[str, Step | None], current: str) -> RenderableType:
    from rich import box
    from rich.table import Table as Grid

    grid = Grid(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, header_style="bold")
    grid.add_column("model")
    for head in ("iteration", "cost", "decrease"):
        grid.add_column(head, justify="right")
    grid.add_column("")
    for model, step in fits.items():
        i = None if step is None else step.iteration
        state = "waits" if i is None else "fitting" if model == current else "done"
        cells = ("", "", "") if i is None else (str(i.number), number(i.cost, 7), number(i.decrease, 2))
        grid.add_row(model, *cells, state, style={"fitting": "", "done": "green", "waits": "dim"}[state])
    return grid
