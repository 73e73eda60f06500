"""The sections of a report with figures: a file and a class each, in the order of the page.

Read `section` first. A new section is one file and one entry of SECTIONS.
"""

from __future__ import annotations

from robotid.report.findings import Findings
from robotid.report.sections.causes import Causes
from robotid.report.sections.location import Location
from robotid.report.sections.parameters import Parameters
from robotid.report.sections.perturbation import PerturbedParameters
from robotid.report.sections.records import Records, References
from robotid.report.sections.residuals import Residuals
from robotid.report.sections.responses import FrequencyResponses
from robotid.report.sections.section import FigureSpec, Section
from robotid.report.sections.traces import Traces

__all__ = ["SECTIONS", "FigureSpec", "Section", "figure_specs"]

SECTIONS: tuple[Section, ...] = (
    Traces(),
    FrequencyResponses(),
    Parameters(),
    Residuals(),
    Location(),
    Causes(),
    PerturbedParameters(),
    Records(),
    References(),
)


def figure_specs(findings: Findings) -> tuple[FigureSpec, ...]:
    """All figures that the findings allow, in the order of the page."""
    return tuple(spec for section in SECTIONS for spec in section.figures(findings))
