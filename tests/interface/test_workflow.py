"""From a log to a named cause by the front door: what comes of each step, is shown, kept and read again."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.alike import alike
from support.hidden_motor import motor_with
from support.logs import STRIBECK, TRUTH, motor_log

import robotid as rid
from robotid.cli.app import main
from robotid.interface.files import RunContents, Setup
from robotid.interface.improvement import DiagnosedFit, ExtendedFit

RIGID = rid.Model(motor=["inertia", "viscous", "coulomb"])


@dataclass(frozen=True)
class Steps:
    """All results of one way through the front door."""

    log: rid.Dataset
    day2: rid.Dataset
    fit: rid.Fit
    found: DiagnosedFit
    better: ExtendedFit


@pytest.fixture(scope="module")
def steps() -> Steps:
    log = rid.read(motor_log(stribeck=True), name="log")
    day2 = rid.read(motor_log(stribeck=True, seed=2), name="day2")
    fit = rid.fit(RIGID, log)
    found = rid.diagnose(fit, held_out=day2)
    return Steps(log, day2, fit, found, rid.extend(fit, found))


def test_the_cause_is_named_and_its_gain_measured_on_what_no_fit_has_seen(steps: Steps) -> None:
    (cause,) = steps.found.causes
    assert (steps.found.verdict, cause.effect) == ("named", "motor.stribeck")
    assert cause.heldout_gain == pytest.approx(5.3, abs=0.3)
    after = steps.better.after["day2"]
    assert (after.used, after.fit_percent > 99.5) == (False, True)


def test_the_extended_fit_has_the_true_values_and_goes_on(steps: Steps) -> None:
    for name, value in (TRUTH | STRIBECK).items():
        assert steps.better.fit[name].value == pytest.approx(value, rel=0.05)
    assert steps.better.fit.model.motor == ("inertia", "viscous", "coulomb", "stribeck")
    assert steps.better.fit.dataset.names == ("log", "day2")


def test_the_front_door_finds_what_the_stages_find(tmp_path: Path) -> None:
    machine = tmp_path / "machine.yaml"
    machine.write_text(motor_with("stribeck", dFs=0.25, vs=2))
    assert main(["fit", str(machine), "--out", str(tmp_path / "run"), "--quiet"]) == 3  # its inputs are missing
    for stage in ("excite", "collect", "init-rigid", "init-flex", "fit"):
        assert main([stage, str(machine), "--out", str(tmp_path / "run"), "--quiet"]) == 0
    setup, run = rid.load(machine), rid.load(tmp_path / "run")
    assert isinstance(setup, Setup)
    assert isinstance(run, RunContents)
    fit = rid.fit(setup.model, setup.records, options=setup.options)
    assert fit.values == run.fit.values
    assert alike(fit.dataset.recordings, run.records.recordings)
    assert fit.fit_percent == run.fit.fit_percent


def test_a_simulation_of_a_fit_is_that_of_its_values(steps: Steps) -> None:
    run = rid.simulate(steps.better.fit, steps.day2)
    again = rid.simulate(steps.better.fit.model, steps.day2[0], steps.better.fit.values)
    np.testing.assert_allclose(again.simulated, run.simulated, atol=1e-3)
    assert run.fit_percent == pytest.approx(steps.better.after["day2"].fit_percent, abs=1e-3)
    np.testing.assert_array_equal(run.residual, steps.day2[0].dphi_m - run.simulated)


def test_known_values_are_kept_and_limits_are_respected(steps: Steps) -> None:
    bounds = {"motor.coulomb.Fc": (0.0, 0.62)}
    fit = rid.fit(RIGID, steps.log, fixed={"motor.inertia.J": 0.0125}, bounds=bounds)
    assert (fit["motor.inertia.J"].value, fit["motor.inertia.J"].remark) == (0.0125, "fixed")
    assert (fit["motor.coulomb.Fc"].value, fit["motor.coulomb.Fc"].remark) == (0.62, "at its upper bound")


def test_where_all_is_known_nothing_is_initialised(steps: Steps) -> None:
    fit = rid.fit(RIGID, steps.log, guesses=steps.fit.values)
    assert (fit.rigid, fit.flex) == (None, None)
    assert fit["motor.coulomb.Fc"].value == pytest.approx(steps.fit["motor.coulomb.Fc"].value, rel=1e-3)


def test_a_validation_sets_the_fit_beside_its_start(steps: Steps) -> None:
    found = rid.validate(steps.fit, steps.day2, perturbation=10.0)
    assert list(found.models) == ["m0", "m1"]
    used = {name: r.used for name, r in found.models["m1"].records.items()}
    assert used == {"log": True, "day2": False}
    assert found.models["m1"].records["log"].perturbation.percent == 10.0


def test_every_result_shows_itself(steps: Steps, tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    run = rid.simulate(steps.fit, steps.log)
    validation = rid.validate(steps.fit, perturbation=None)
    for result in (steps.log, steps.log[0], steps.fit, run, validation, steps.found, steps.better):
        assert re.fullmatch(r"<\w+: .+>", repr(result))
        shown, page = str(result), result._repr_html_()
        assert all(line == line.rstrip() for line in shown.splitlines())
        assert page.count("<table>") == page.count("</table>") >= 1
        assert len(result.table()) >= len(shown)
        assert len(result.to_frame()) >= 1
        file = tmp_path / f"{type(result).__name__}.svg"
        result.plot().savefig(file)
        assert "<svg" in file.read_text()


def test_a_frame_holds_the_numbers(steps: Steps) -> None:
    pytest.importorskip("pandas")
    frame = steps.fit.to_frame()
    assert frame.loc["motor.inertia.J", "value"] == steps.fit["motor.inertia.J"].value
    assert steps.better.to_frame().loc["day2", "fit_after"] == steps.better.after["day2"].fit_percent
    assert list(steps.found.to_frame().index) == ["motor.stribeck"]
    np.testing.assert_array_equal(steps.log[0].to_frame()["tau_m"], steps.log[0].tau_m)


def test_without_pandas_a_frame_says_what_to_install(steps: Steps, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with pytest.raises(rid.RobotidError, match=r"a data frame needs pandas; pip install 'robotid\[pandas\]'"):
        steps.fit.to_frame()


def test_a_folder_keeps_all_that_a_result_rests_on(steps: Steps, tmp_path: Path) -> None:
    rid.save(steps.found, tmp_path / "run")
    rid.save(steps.better, tmp_path / "run")
    run = rid.load(tmp_path / "run")
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == [
        "diagnosis.h5", "extension.h5", "flex.h5", "model.h5", "records.h5", "rigid.h5"
    ]  # fmt: skip
    assert alike(run.diagnosis.result, steps.found.result)
    assert alike(run.extension.result, steps.better.result)
    assert alike(run.fit.result, steps.fit.result)
    assert run.model == RIGID
    again = rid.extend(run.fit, run.diagnosis)
    assert again.added == steps.better.added
    assert rid.load(tmp_path / "run" / "diagnosis.h5").causes[0].effect == "motor.stribeck"


@pytest.mark.parametrize("part", ["fit", "found", "better"])
def test_the_command_line_shows_what_was_saved(
    part: str, steps: Steps, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = rid.save(getattr(steps, part), tmp_path / "saved.h5")
    assert main(["show", str(file)]) == 0
    shown = capsys.readouterr().out
    assert ("made by   rid." in shown, "motor." in shown) == (True, True)


def test_a_validation_is_saved_alone(steps: Steps, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = rid.validate(steps.fit, perturbation=None)
    again = rid.load(rid.save(found, tmp_path / "validation.h5"))
    assert alike(again, found)
    assert main(["show", str(tmp_path / "validation.h5")]) == 0


def test_what_is_being_done_is_reported(steps: Steps) -> None:
    lines: list[str] = []
    rid.extend(steps.fit, steps.found, log=lines.append)
    assert "fitting with motor.stribeck" in lines


def test_numbers_of_numpy_do_as_well() -> None:
    ratio, guess = np.float64(0.01), {"motor.inertia.J": np.float64(0.01)}
    model = rid.Model(motor=["inertia"], gear=["spring"], arm=("inertia",), gear_ratio=ratio).with_known(guess)
    assert model.structure.gear_ratio == 0.01


def test_datasets_are_sequences_that_cannot_change(steps: Steps) -> None:
    data = steps.log + steps.day2.as_role("validate")
    assert (len(data), data[0].name, data[-1].name, data["day2"].role) == (2, "log", "day2", "validate")
    assert data[1:].names == data.of_role("validate").names == ("day2",)
    assert [record.name for record in data] == ["log", "day2"]
    with pytest.raises(AttributeError):
        data.records = ()  # type: ignore[misc]


BAD: dict[str, tuple[Callable[[Steps], Any], str]] = {
    "unknown effect": (lambda s: rid.Model(motor=["inertia", "stribek"]), "Model, motor[1]: there is no effect"),
    "at no such place": (lambda s: rid.Model(motor=["inertia", "spring"]), "spring does not act at motor"),
    "no inertia": (lambda s: rid.Model(motor=["viscous"]), "the motor has no inertia; add inertia to motor"),
    "no ratio": (lambda s: rid.Model(motor=["inertia"], arm=["gravity"]), "give gear_ratio=phi_a / phi_m"),
    "ratio upside down": (lambda s: rid.Model(motor=["inertia"], gear_ratio=100), "did you mean 0.01?"),
    "no list": (lambda s: rid.Model(motor=[3]), "motor is a list of names of effects"),  # type: ignore[list-item]
    "unknown parameter": (lambda s: RIGID.with_known({"motor.inertia.I": 1.0}), "did you mean motor.inertia.J?"),
    "outside its bounds": (lambda s: RIGID.with_known({"motor.inertia.J": -1.0}), "lies outside the bounds"),
    "bounds turned": (lambda s: RIGID.with_known(bounds={"motor.inertia.J": (2, 1)}), "is not below the upper bound"),
    "no bounds": (lambda s: RIGID.with_known(bounds={"motor.inertia.J": 1}), "give (lower, upper)"),  # type: ignore[dict-item]
    "no value": (lambda s: rid.Model(motor=["inertia"], known={"motor.inertia.J": "x"}), "is no value of"),  # type: ignore[dict-item]
    "no place": (lambda s: RIGID.with_effects("motr.stribeck"), "did you mean motor?"),
    "an effect alone": (lambda s: RIGID.with_effects("stribeck"), "write it as port.effect"),
    "no record": (lambda s: rid.fit(RIGID, []), "there is no record, so there is nothing to fit"),
    "all held out": (lambda s: rid.fit(RIGID, s.log.as_role("validate")), "every record has the role validate"),
    "a file for a record": (lambda s: rid.fit(RIGID, ["log.csv"]), "a record was expected, found str"),  # type: ignore[list-item]
    "a number for records": (lambda s: rid.fit(RIGID, 3), "a record was expected, found int"),  # type: ignore[arg-type]
    "an unknown weight": (lambda s: rid.fit(RIGID, s.log, options=rid.Options(weights={"lg": 1})), "did you mean log?"),
    "an unknown output": (lambda s: rid.Options(output="torque"), "speed or position"),  # type: ignore[arg-type]
    "a band of one": (lambda s: rid.Options(band=5), "give (lowest, highest) in Hz"),  # type: ignore[arg-type]
    "no horizon": (lambda s: rid.Options(horizon=0.0), "Options: horizon is 0.0; give a positive number, or None"),
    "nothing rigid": (lambda s: rid.fit(RIGID, rid.read(motor_log(), use="flex")), 'read one with use="rigid"'),
    "a wrong name": (lambda s: s.fit["motor.inertia.j"], "did you mean motor.inertia.J?"),
    "an unknown record": (lambda s: s.log["lg"], 'there is no record "lg"; did you mean log?'),
    "twice": (lambda s: rid.diagnose(s.fit, held_out=s.log), 'two records have the name "log"; give one'),
    "missing values": (lambda s: rid.simulate(RIGID, s.log), "a value is missing for motor.inertia.J, motor.viscous"),
    "a wrong value's name": (lambda s: rid.simulate(s.fit, s.log, {"motor.inertia.I": 1.0}), "did you mean"),
    "no number": (lambda s: rid.simulate(s.fit, s.log, {"motor.inertia.J": np.nan}), "a value is not a number"),
    "two at a time": (lambda s: rid.simulate(s.fit, s.log + s.day2), "choose one: log, day2"),
    "another's diagnosis": (lambda s: rid.extend(s.better.fit, s.found), "this is no diagnosis of this fit"),
    "already there": (lambda s: rid.extend(s.fit, s.found, effects=["motor.coulomb"]), "is in the model already"),
    "an unknown addition": (lambda s: rid.extend(s.fit, s.found, effects=["motor.cog"]), 'there is no effect "cog"'),
    "nothing to save": (lambda s: rid.save(3, "a.h5"), "of type int cannot be saved"),  # type: ignore[arg-type]
    "saved as": (lambda s: rid.save(s.fit, "a.csv"), "results are saved as .h5"),
    "nothing to load": (lambda s: rid.load("nowhere.h5"), "nowhere.h5: there is no such file"),
    "a log to load": (lambda s: rid.load(__file__), '".py" is no artifact and no configuration'),
    "explain": (lambda s: rid.explain("motor.spring"), "spring does not act at motor"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_use_is_one_clear_sentence(case: str, steps: Steps) -> None:
    call, words = BAD[case]
    with pytest.raises(rid.RobotidError) as caught:
        call(steps)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_diagnosis_without_its_records_asks_for_them(steps: Steps, tmp_path: Path) -> None:
    alone = rid.load(rid.save(steps.fit, tmp_path / "model.h5"))
    with pytest.raises(rid.RobotidError, match="the records of this fit are not here: log"):
        rid.diagnose(alone, held_out=steps.day2)
    assert rid.validate(alone, steps.log, perturbation=None).models["m1"].records["log"].used


def test_pieces_are_chosen_where_that_is_asked() -> None:
    fit = rid.fit(RIGID, rid.read(motor_log(), name="log"), options=rid.Options(horizon="auto"))
    assert fit.horizon is None
    assert fit.options.horizon is None
    assert fit.remarks[-1].startswith("horizon: auto fits whole records")
    with pytest.raises(rid.RobotidError, match='horizon is "soon"; give seconds, "auto" or None'):
        rid.Options(horizon="soon")  # type: ignore[arg-type]


def test_pieces_that_a_fit_was_cut_into_are_longer_for_a_coarser_record() -> None:
    coarse = rid.read({name: values[:800:4] for name, values in motor_log(seed=2).items()}, name="coarse")
    fine = rid.read({name: values[:800] for name, values in motor_log().items()}, name="fine")
    fit = rid.fit(RIGID, fine, options=rid.Options(horizon=0.1))
    assert fit.output == "speed", "though only the angle was logged"
    found = rid.diagnose(fit, held_out=coarse, criteria=rid.Criteria(max_refits=1, max_causes=1))
    assert "coarse" in found.records
    assert rid.extend(fit, found).added == ()
