"""Changes as candidates: a fitted parameter that is another in one record, as of a payload or a warm gearbox."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf

from robotid.diagnosis.scoring.candidate import Candidate
from robotid.model.joint import Joint
from robotid.model.parameters import Parameter
from robotid.model.structure import change


@dataclass(frozen=True, slots=True)
class RecordChangeCandidate(Candidate):
    """A parameter of the joint, theta[column], that is another in one record.

    Its column is that of the parameter, on that record alone, and needs no solve of its own.
    """

    record: str
    column: int
    parameter: Parameter

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (self.parameter,)

    def start(self, amplitude: Sequence[float]) -> Mapping[str, float]:
        """Its name is that of its only parameter."""
        return {self.name: amplitude[0]}


def record_changes(joint: Joint, columns: Sequence[int], records: Sequence[str]) -> tuple[RecordChangeCandidate, ...]:
    """Every fitted parameter of a term, shapes apart, as different in each record. columns : indices into theta."""
    found = []
    for record in records:
        for k in columns:
            name = change(record, joint.names[k])
            if k < joint.n_theta and not joint.declared[k].is_shape and name not in joint.names:
                declared = replace(joint.declared[k], bounds=(-inf, inf), null=0.0)
                found.append(RecordChangeCandidate(name, (0.0,), record, k, declared))
    return tuple(found)
