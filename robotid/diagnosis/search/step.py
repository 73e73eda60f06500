"""A step of the search: a model before and after a cause, as the tests of a cause see it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import refit_to_confirm
from robotid.diagnosis.refit.refitted_model import RefittedModel, Trajectories
from robotid.diagnosis.scoring.blocked_regression import Gain
from robotid.diagnosis.search.carry_over import gain_by_blocks, together
from robotid.diagnosis.search.coloured import (
    ALONE,
    Left,
    Tried,
    blocks_with,
    by_blocks,
    confirmation,
    in_the_shape,
    left_by,
    p_value,
)
from robotid.diagnosis.search.drawn_sizes import DrawnSizes
from robotid.diagnosis.search.physical_sense import amplitudes, declarations
from robotid.diagnosis.search.state import share_removed
from robotid.errors import NumericsError
from robotid.estimate.residual import measured_output
from robotid.model.array import Array
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure
from robotid.parallel import each


@dataclass(frozen=True, eq=False)
class Step:
    """A model before and after a cause is added.

    first : the model that is diagnosed; tried : what it is the best of; confirmed : p-value of what a part of the
    records that did not serve to find it shows of it.
    """

    first: RefittedModel
    before: RefittedModel
    after: RefittedModel
    data: EvaluationData
    tried: Tried = ALONE
    confirmed: float = 1.0

    @cached_property
    def left(self) -> Left:
        """What the model with the cause leaves, by noise of any colour."""
        return left_by(self.after)

    @cached_property
    def left_out(self) -> Gain | None:
        """What the amplitudes of the step explain of every block of the fitted records by an estimate from all others,
        in the shape that was found and beside noise of any colour; None where no amplitude was fitted, or that noise
        is not known. In a shape that is a little off, what is periodic would be out of phase a few periods on."""
        sizes = {k: size for effect in self.added for k, size in amplitudes(self.after, effect).items()}
        if not sizes:
            return None
        try:
            blocks = blocks_with(self.left, sizes)
        except NumericsError:
            return None
        own = [k for effect in self.added for k in self.after.own_columns(effect)]
        shaped, there = in_the_shape(blocks, list(sizes), own)
        return shaped.gain(there)

    @cached_property
    def elsewhere(self) -> RefittedModel | None:
        """The model with the cause, refitted to the validation segments alone; None where it cannot be. The cause is
        nothing at first, lest its size only stays what it was, or the size that it was where that suits these segments
        better: from nothing a fit may get stuck where a cause moves the joint much."""
        nothing = {name: p.null for one in self.added for name, p in declarations(one) if p.null is not None}
        near = Trajectories(tuple(one.trajectory for one in self.after.validation))
        if not self.data.validation:
            return None
        starts = (self.after.parameters.with_values(nothing), self.after.parameters)
        alone = self._alone(self.data.validation)
        found = each(_refitted, (self.after.structure, alone, near), starts, samples=alone.samples)
        return min((one for one in found if one is not None), key=lambda one: one.energy, default=None)

    def refitted_to(self, fitted: tuple[Segment, ...], start: Parameters, near: Trajectories) -> RefittedModel | None:
        """The model with the cause, refitted to other segments alone; None where it cannot be. start : from where;
        near : trajectories near to the solution."""
        return _refitted((self.after.structure, self._alone(fitted), near), start)

    def _alone(self, fitted: tuple[Segment, ...]) -> EvaluationData:
        return replace(self.data, fitted=fitted, validation=())

    @property
    def added(self) -> tuple[str, ...]:
        """The effects that the step adds."""
        old = self.before.structure.effects
        return tuple(effect for effect in self.after.structure.effects if effect not in old)

    @property
    def share(self) -> float:
        """Share of the first model's misfit that the step removes from the fitted segments."""
        return share_removed(self.first, self.before, self.after, self.data)

    @property
    def share_of_motion(self) -> float:
        """Squared error that the step removes from the fitted segments, of what a model without motion leaves there."""
        before, after = (_squared([one.residual for one in model.fitted]) for model in (self.before, self.after))
        measured = [measured_output(one.record, self.data.output) for one in self.after.fitted]
        motion = _squared([y - y.mean() for y in measured])
        return (before - after) / motion if motion > 0.0 else 0.0

    @property
    def gain(self) -> float:
        """Of the fit on the validation segments [% points], nan without any."""
        return self.after.validation_fit_percent - self.before.validation_fit_percent

    @cached_property
    def held_out(self) -> Gain | None:
        """What the step gains on every block of the validation segments; None without any."""
        return gain_by_blocks(self.before.validation, self.after.validation) if self.data.validation else None

    @property
    def energy_a_sample(self) -> float:
        """Energy that the step removes, a sample, in variances of the noise; on the validation segments, or on the
        fitted ones where there are no others."""
        if self.data.validation:
            return (self.before.validation_energy - self.after.validation_energy) / self.data.validation_samples
        return (self.before.energy - self.after.energy) / self.data.samples

    @cached_property
    def confirmation(self) -> float:
        """p-value of what the step adds being absent from the validation records, which are fitted alone, beside noise
        of any colour; one where they ask for another size of it."""
        other = self.elsewhere
        if other is None:
            return 1.0
        sizes = {one: amplitudes(self.after, one) for one in self.added}
        found = (confirmation(other, one, size) for one, size in sizes.items() if size)
        return min(1.0, self.tried.effects * max(found, default=1.0))

    @cached_property
    def p_value(self) -> float:
        """Of what the step adds being absent, by noise of any colour and by its gain on the validation segments."""
        fitted = self._p_value()
        if self.confirmed < 1.0:
            fitted = min(fitted, max(self.tried.effects * self.confirmed, self._by_blocks))
        found = together(fitted, self.held_out, self.tried.refits)
        # what these segments ask for by themselves knows of their gain, and does not count with it
        return min(found, self._p_value(lambda: self.elsewhere))

    def _p_value(self, elsewhere: Callable[[], RefittedModel | None] = lambda: None) -> float:
        """By noise of any colour alone. elsewhere : as of `coloured.p_value`."""
        return max((p_value(self.after, one, self.left, self.tried, elsewhere) for one in self.added), default=0.0)

    @property
    def _by_blocks(self) -> float:
        """From block to block alone, of nothing but what the step adds: what a part of the records has confirmed is no
        longer the best of many, but errors that last from one part to the other confirm each other."""
        found = []
        for one in self.added:
            if sizes := amplitudes(self.after, one):
                found.append(by_blocks(blocks_with(self.left, sizes), list(sizes), self.after.own_columns(one)))
        return max(found, default=0.0)

    def p_value_in_motion(self, level: float) -> float:
        """By noise of any colour alone where errors of the torque pass along the motion, which rests and reverses:
        linear about every sample, or, where that is not below this level of significance, by simulations, which take
        longer."""
        found = [DrawnSizes.of(self.after, one, self.left) for one in self.added]
        return max((one.p_value(level) for one in found if one is not None), default=0.0)


def _refitted(shared: tuple[Structure, EvaluationData, Trajectories], start: Parameters) -> RefittedModel | None:
    """A model refitted from given values, None where it cannot be. shared : its structure, the segments, and
    trajectories near to the solution."""
    structure, data, near = shared
    return refit_to_confirm(structure, start, data, near)


def _squared(signals: Sequence[Array]) -> float:
    return float(sum(np.sum(np.square(one)) for one in signals))
