import numpy as np

from robotid.signals.reference import Excitation, Reference


def test_time_axis() -> None:
    reference = Reference("a", 0.25, np.zeros(5), "speed")
    assert reference.t.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert (len(reference), reference.duration) == (5, 1.25)


def test_references_by_name() -> None:
    a, b = (Reference(name, 0.25, np.zeros(5), "speed") for name in "ab")
    assert Excitation((a, b))["b"] is b
