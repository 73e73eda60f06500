"""Draws the picture of the README: what is wrong, where, why, and what the correction gains.

Run from the project's root, after `robotid run configs/hidden.yaml`: python data/make_picture.py runs/hidden
data/picture.svg. `make picture` does both.
"""

from __future__ import annotations

import sys
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from robotid.artifacts.store import load
from robotid.diagnosis.results import Diagnosis
from robotid.extension.results import Extension
from robotid.report.drawing.causes import draw_causes
from robotid.report.drawing.gain import draw_gain
from robotid.report.drawing.location import best_of_each, draw_curve
from robotid.report.drawing.time import draw_strips, extended_plot
from robotid.report.style.axes import legend, new_figure

SIZE = (9.6, 5.6)  # [inch]
RECORD = "check"  # a validation record


def picture(diagnosis: Diagnosis, extension: Extension) -> Figure:
    """A record before and after above; where the misfit sits, its cause and the gain below."""
    figure = new_figure(*SIZE)
    upper, lower = figure.subfigures(2, 1, height_ratios=(1.15, 1))
    strips = list(upper.subplots(2, 1, sharex=True, height_ratios=(2, 1.2)))
    before, after = extension.before[RECORD], extension.after[RECORD]
    draw_strips(strips, extended_plot(RECORD, before, after, extension.output), most=1600)
    legend(strips[0], columns=3)
    where, why, gain = lower.subplots(1, 3, width_ratios=(1, 1.15, 1))
    draw_curve(where, best_of_each(diagnosis.curves)[0])
    where.set_title("where: the missing torque", fontsize=10, loc="left")
    draw_causes(why, diagnosis, most_rejected=4)
    why.set_title("why: effects of the catalogue, ranked", fontsize=10, loc="left")
    draw_gain([gain], extension, ("held-out records",))
    gain.set_title("gain on the validation record", fontsize=10, loc="left")
    return figure


def main(run: Path, file: Path) -> None:
    """Write the picture of a run."""
    diagnosis = load(run / "diagnosis.h5", Diagnosis).content
    extension = load(run / "extension.h5", Extension).content
    with rc_context({"svg.hashsalt": "robotid", "svg.fonttype": "path"}):
        picture(diagnosis, extension).savefig(file, metadata={"Date": None})


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
