"""A virtual robot whose axes move together: one motion for all axes, and the references that tell them apart."""

from __future__ import annotations

import numpy as np
import pytest
from support.coupled_axes import axes, chain
from support.moving_axes import THREE, TWO

from robotid.config.load import parse_axes
from robotid.signals.frf_matrix import estimate_frf_matrix
from robotid.signals.quality import Recordings
from robotid.simulation.coupled.coupled_robot import CoupledRobot
from robotid.stages.collect import Common, collect
from robotid.stages.excite import References, excite


def collected(text: str) -> dict[str, Recordings]:
    references, common = References(), Common()
    configs = parse_axes(text)
    made = {axis: excite(config, references) for axis, config in configs.items()}
    return {axis: collect(config, made[axis], {}, shared=common) for axis, config in configs.items()}


def test_the_records_are_those_of_the_coupled_robot() -> None:
    found = collected(TWO)
    first, second = parse_axes(TWO).values()
    references = {"a1": excite(first)["one"], "a2": excite(second)["one"]}
    robot = CoupledRobot(dict(zip(("a1", "a2"), axes(seed=3), strict=True)), chain())
    made = robot.record(references, 0, {"a2": 0.5})
    for axis, recordings in found.items():
        record = recordings["one"]
        assert record.phi_m == pytest.approx(made[axis].phi_m, abs=1e-12)
        assert record.tau_m == pytest.approx(made[axis].tau_m, abs=1e-12)
        assert (record.role, recordings["two"].role) == ("estimate", "validate")
    assert found["a2"]["one"].phi_m[0] == pytest.approx(0.5 / 0.0125)
    companions = found["a1"]["one"].companions
    assert companions["a2"].values == pytest.approx(0.0125 * found["a2"]["one"].phi_m)
    assert companions["tau_a2"].values == pytest.approx(found["a2"]["one"].tau_m)


def test_an_axis_by_itself_moves_as_among_the_others() -> None:
    together = collected(TWO)["a2"]["two"]
    config = parse_axes(TWO)["a2"]
    alone = collect(config, excite(config), {})["two"]
    assert np.array_equal(alone.phi_m, together.phi_m)
    assert np.array_equal(alone.tau_m, together.tau_m)


def test_axes_have_phases_of_their_own() -> None:
    text = TWO.replace("band: [5, 40]", "band: [5, 30]").replace("peak: 25", "peak: 20")
    first, second = (excite(config)["two"].ref for config in parse_axes(text).values())
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.9
    spectra = [np.abs(np.fft.rfft(one)) / one.std() for one in (first, second)]
    assert spectra[0] == pytest.approx(spectra[1], abs=1e-9)


def test_orthogonal_multisines_tell_three_axes_apart() -> None:
    """Wernholt & Moberg 2008: at every line the columns of amplitudes, one an experiment, are orthogonal."""
    found = [excite(config).references for config in parse_axes(THREE).values()]
    spectra = np.array([[np.fft.rfft(one.ref[:250]) for one in axis] for axis in found])  # (axes, experiments, lines)
    for line in (1, 7, 20):
        U = spectra[:, :, line]
        power = 3.0 * np.diag(np.abs(U[:, 0]) ** 2)
        products = U @ U.conj().T
        assert products == pytest.approx(power, abs=1e-6)
        assert power.trace() > 1e3


def test_three_axes_move_together() -> None:
    found = collected(THREE)
    names = ("one", "one_r2", "one_r3")
    matrix = estimate_frf_matrix([{axis: found[axis][name] for axis in found} for name in names])
    assert np.linalg.cond(np.moveaxis(matrix.response, -1, 0)).max() < 1e4
    assert list(found["a2"]["one"].companions) == ["a1", "a3", "tau_a1", "tau_a3"]
    assert found["a1"]["one"].tau_m.mean() * 50 > 9.81 * (5 * 0.2 + 3 * 0.4)  # it carries all links, stretched level
