"""The command check: whether the records make sense, before anything is fitted."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from robotid.cli.console import print_json, print_message, print_tables
from robotid.cli.progress import watching
from robotid.pipeline.check import check, require_meaningful
from robotid.pipeline.lock import locked
from robotid.pipeline.run import Runs
from robotid.report.tables import by_axis
from robotid.report.tables import check as view


def check_configuration(run: Runs, accepted: Sequence[str], *, as_json: bool, quiet: bool) -> None:
    """Print all findings. Raises NumericsError where a fit would be meaningless, and what `collect` raises."""
    with locked(run.out, run.command("check"), partial(print_message, quiet=quiet)), watching(quiet=quiet) as log:
        found = check(run, accepted, log=log)
    if as_json:
        print_json(by_axis.document({axis: view.document(one) for axis, one in found.items()}))
    elif not quiet:
        print_tables([*by_axis.tables(view, found, dict.fromkeys(found, False))])
    require_meaningful(run, found)
    for sentence in by_axis.sentences(view, found, dict.fromkeys(found, False)):
        print_message(sentence, quiet=quiet)
    print_message(f"next: {run.command('run')}", quiet=quiet)
