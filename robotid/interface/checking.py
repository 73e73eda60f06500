"""Whether records make sense, before anything is fitted to them."""

from __future__ import annotations

from collections.abc import Iterable

from robotid.config.suggest import suggest
from robotid.errors import ConfigError
from robotid.interface.dataset import as_dataset
from robotid.interface.model import Model
from robotid.signals.plausibility import CHECKS, Axis, Plausibility, check_records
from robotid.signals.record import Record


def check(
    records: Record | Iterable[Record], *, model: Model | None = None, accept: Iterable[str] = ()
) -> Plausibility:
    """Check whether records make sense, as `robotid check` does: the signs of torque and speed, units, columns that
    were mistaken for others, clock, resolution, and what of the joint the motion shows.

    model : its gear ratio says on which side of the gear sizes are plausible, and whether the axis slides; without one
    the axis is rigid and turns. accept : names of checks whose findings are known to be right.

    The result prints a line for each finding, and is true where a fit means something. Raises ConfigError for a check
    that does not exist.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> log = motor_log()
    >>> bool(rid.check(rid.read(log)))
    True
    >>> found = rid.check(rid.read(log | {"torque": -log["torque"]}))
    >>> bool(found), [finding.name for finding in found.fatal]
    (False, ['torque_sign'])
    """
    data, accepted = as_dataset(records), tuple(accept)
    for name in accepted:
        if name not in CHECKS:
            raise ConfigError(f'there is no check "{name}"', where="accept", hint=suggest(name, CHECKS, many=20))
    axis = Axis() if model is None else Axis(model.gear_ratio, model.linear)
    return check_records(data.recordings, axis, accepted)
