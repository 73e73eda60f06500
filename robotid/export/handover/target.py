"""A program that a model is handed over to: what it can express, and the file that it reads."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import ClassVar

from robotid import __version__
from robotid.export.handover.cost import costs
from robotid.export.handover.handed_model import Cost, HandedModel, HandOver
from robotid.numerals import fixed, plain

OF_A_SIGNAL = "it acts on a signal, not on the joint"


class Target(ABC):
    """A program, in a file of `robotid.export.targets`. The class is its whole specification.

    name : that of its file; suffix : of the files that it reads; summary : what is written, in a few words; patches :
    whether it can write into a file that is there.
    """

    name: ClassVar[str]
    suffix: ClassVar[str]
    summary: ClassVar[str]
    patches: ClassVar[bool] = False

    @abstractmethod
    def omitted(self, model: HandedModel) -> dict[str, str]:
        """Effects that the program cannot express, and why."""

    @abstractmethod
    def text(self, model: HandedModel, comment: Sequence[str]) -> str:
        """The file, of a model whose effects can all be expressed. comment : lines to stand at its head.

        Raises ConfigError for a file that cannot be patched.
        """

    def reduced(self, model: HandedModel, omitted: Mapping[str, str]) -> HandedModel:
        """The model as the program has it."""
        return model.without(omitted)

    def remarks(self, model: HandedModel) -> tuple[str, ...]:
        """What whoever uses the file should know, in sentences."""
        return ()

    def hand_over(self, model: HandedModel) -> HandOver:
        """The file, with what it lacks and what that costs on the records of the model."""
        omitted = self.omitted(model)
        reduced = self.reduced(model, omitted)
        lost = costs(model, reduced) if model.fit.structure != reduced.fit.structure else ()
        remarks = self.remarks(model)
        comment = [
            f"{model.robot}, model {model.fit.name}: written by robotid {__version__}.",
            *remarks,
            *described(omitted, lost),
        ]
        return HandOver(self.text(reduced, comment), omitted, lost, remarks)


def described(omitted: Mapping[str, str], lost: Sequence[Cost]) -> list[str]:
    """What a file lacks, and what that costs, in lines."""
    if not omitted and not lost:
        return ["It has every effect of the model."]
    lines = [f"It lacks {effect}: {why}." for effect, why in omitted.items()]
    return lines + [
        f"On {one.record} the whole model fits {fixed(one.before)} %, and this one {_after(one)}." for one in lost
    ]


def _after(one: Cost) -> str:
    if one.after is None or one.difference is None:
        return "diverges"
    return f"{fixed(one.after)} % (they differ by {plain(one.difference)} {one.unit} RMS)"


def xml_comments(lines: Sequence[str]) -> list[str]:
    """Lines as comments of XML, in which no two hyphens stand together."""
    return [f"<!-- {re.sub('-(?=-)', '- ', line)} -->" for line in lines]
