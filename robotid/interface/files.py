"""What is kept in files: artifacts, run directories and configurations, read and written."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from robotid.artifacts.provenance import Provenance
from robotid.artifacts.store import load as load_artifact
from robotid.artifacts.store import read_header, read_headers
from robotid.artifacts.store import save as save_artifact
from robotid.catalogue import assemble
from robotid.config.extended import changes_of, effects_of
from robotid.config.load import Loaded, load_robot, parse, require_axis, resolved
from robotid.config.schema import Config
from robotid.diagnosis import Diagnosis
from robotid.display import Displayed
from robotid.errors import ConfigError, InputError
from robotid.estimate.flexible import FlexResult
from robotid.estimate.identify import starting_parameters
from robotid.estimate.result import FitResult, Fits
from robotid.estimate.rigid import RigidResult
from robotid.extension import Extension
from robotid.interface.dataset import Dataset
from robotid.interface.identification import Fit, Options, extended_fit, fields_of
from robotid.interface.improvement import DiagnosedFit, ExtendedFit
from robotid.interface.model import Model, model_of
from robotid.model.structure import Structure
from robotid.model.units import on_axis
from robotid.pipeline.stage import Stage
from robotid.pipeline.table import STAGES
from robotid.report.display import View, shows, view_of
from robotid.report.tables.table import Table
from robotid.signals.joining import joined
from robotid.signals.quality import Recordings
from robotid.signals.readers import formats
from robotid.signals.readers import read as read_table
from robotid.stages.collect import collect
from robotid.stages.excite import excite
from robotid.validation import Validation

CONFIGURATIONS = (".yaml", ".yml")


@dataclass(frozen=True, eq=False, repr=False)
class Setup(Displayed):
    """A configuration file: config : all that it says; model, options, records : as `rid.fit` takes them."""

    loaded: Loaded

    @property
    def config(self) -> Config:
        """The configuration, complete with its defaults."""
        return self.loaded.config

    @property
    def model(self) -> Model:
        """The effects of the joint, and what is known of their parameters."""
        fixed = self.config.fit.fix
        return model_of(self.config).with_known(fixed=fixed)

    @property
    def options(self) -> Options:
        """How the configuration asks to fit."""
        return options_of(self.config)

    @cached_property
    def records(self) -> Dataset:
        """The records, read from their files or made by the virtual robot when they are first asked for. Raises what
        reading them raises."""
        config = self.config
        here = self.loaded.directory
        files = {r.name: joined([read_table(here / file) for file in r.files]) for r in config.records if r.files}
        made = collect(config, excite(config), files)
        return Dataset(made.records, made.reports)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RunContents(Displayed):
    """What a run directory holds, None or empty where a stage has not run. fits : every fitted model by name; fit : the
    one that later stages use; config, model : of the run."""

    folder: Path
    config: Config
    model: Model
    records: Dataset
    rigid: RigidResult | None = None
    flex: FlexResult | None = None
    fits: Mapping[str, Fit] = field(default_factory=dict)
    fit: Fit | None = None
    validation: Validation | None = None
    diagnosis: DiagnosedFit | None = None
    extension: ExtendedFit | None = None


def options_of(config: Config) -> Options:
    """How a configuration asks to fit."""
    section, rigid, flex = config.fit, config.init_rigid, config.init_flex
    return Options(
        output=section.output,
        horizon=section.horizon,
        max_iterations=section.max_iterations,
        tolerance=section.tolerance,
        weights=section.weights,
        estimate_states=section.initial_states == "free",
        multistart=section.multistart,
        cutoff=rigid.cutoff,
        order=rigid.order,
        min_speed=rigid.min_speed,
        band=flex.band,
        window=flex.window,
    )


def load(path: str | Path, axis: str | None = None) -> Any:
    """Load a configuration, a run directory, or one artifact.

    A configuration (.yaml) is a `Setup` with model, records and options. A run directory is a `RunContents` with
    records, fits, validation, diagnosis and extension, as far as they were made. An artifact (.h5) is what it holds: a
    `Dataset`, a `Fit` (of the best model), a `Validation`, a `DiagnosedFit`, an `ExtendedFit`; the records and the fit
    that a diagnosis is of are those of the artifacts beside it. What is loaded depends on the file, so that its type is
    not known beforehand.

    Of a robot of several axes, `axis` names the one to load; without it, a dictionary has each of them by its name.

    Raises InputError for a file that is missing, foreign, damaged or of another version, ConfigError for a
    configuration that does not fit together, and for an axis that is not there.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> fit = rid.fit(rid.Model(motor=["inertia", "viscous", "coulomb"]), rid.read(motor_log(), name="log"))
    >>> again = rid.load(rid.save(fit, folder / "run"))
    >>> again.fit.values == fit.values, again.records.names
    (True, ('log',))
    """
    path = Path(path)
    if path.is_dir():
        return _one_or_all(_all_axes(path), axis, lambda name: _run(path, name), path)
    if path.suffix.lower() in CONFIGURATIONS:
        loaded = load_robot(path)
        return _one_or_all(loaded, axis, lambda name: Setup(loaded[name]), path)
    if not path.is_file():
        raise InputError("there is no such file", where=str(path), hint="check the path")
    if path.suffix.lower() not in (".h5", ".hdf5"):
        hint = "rid.read reads logs" if path.suffix.lower() in formats() else "give a .yaml, a .h5 or a run directory"
        raise InputError(f'"{path.suffix}" is no artifact and no configuration', where=str(path), hint=hint)
    return _one_or_all(_axes(path), axis, lambda name: _artifact(path, name), path)


def _one_or_all(axes: Iterable[str], axis: str | None, loaded: Callable[[str], Any], path: Path) -> Any:
    """What is loaded of a single joint, of one axis, or of each axis by its name."""
    names = list(axes)
    if axis is not None:
        require_axis([name for name in names if name], axis, str(path))
        return loaded(axis)
    return loaded("") if names == [""] else {name: loaded(name) for name in names}


def _axes(path: Path) -> list[str]:
    """The axes that an artifact holds, "" for a single joint."""
    return list(read_headers(path))


def _all_axes(folder: Path) -> list[str]:
    """The axes that the artifacts of a folder hold; those that hold the most are the first ones to be made."""
    return list(dict.fromkeys(axis for file in _artifacts(folder) for axis in _axes(file)))


def save(result: Fit | DiagnosedFit | ExtendedFit | Validation, path: str | Path) -> Path:
    """Save a result so that `rid.load`, and `robotid show` on the command line, read it.

    path : a file that ends in .h5 takes the result alone; a folder takes it with all that it rests on, the records, the
    initialisations and the fit, under the names of a run directory. Returns the path.

    Raises ConfigError for what cannot be saved, InputError where the file cannot be written.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> fit = rid.fit(rid.Model(motor=["inertia", "viscous", "coulomb"]), rid.read(motor_log(), name="log"))
    >>> rid.save(fit, folder / "model.h5").name
    'model.h5'
    """
    path, contents = Path(path), _contents(result)
    if path.suffix not in ("", ".h5") and not path.is_dir():
        raise ConfigError("results are saved as .h5", where=str(path), hint="name a .h5 file, or a folder")
    configuration = _configuration(result)
    if path.suffix == ".h5":
        _write(path, contents[-1], configuration)
    else:
        for content in contents:
            _write(path / _stage_of(content).output, content, configuration)
    return path


def _contents(result: object) -> list[Any]:
    """What artifacts keep of a result and of what it rests on, the result last."""
    if isinstance(result, Fit):
        before: list[Any] = [result.dataset.recordings] if len(result.dataset) else []
        found = [one for one in (result.rigid, result.flex) if one is not None]
        return [*before, *found, Fits({result.name: result.result}, result.name)]
    if isinstance(result, DiagnosedFit):
        return [*_with_records(_contents(result.fit), result.dataset), result.result]
    if isinstance(result, ExtendedFit):
        return [*_with_records(_contents(result.origin), result.fit.dataset), result.result]
    if isinstance(result, Validation):
        return [result]
    hint = "save what rid.fit, rid.validate, rid.diagnose or rid.extend returns"
    raise ConfigError(f"a result of type {type(result).__name__} cannot be saved", where="save", hint=hint)


def _with_records(contents: list[Any], data: Dataset) -> list[Any]:
    others = [content for content in contents if not isinstance(content, Recordings)]
    return [*([data.recordings] if len(data) else []), *others]


def _stage_of(content: object) -> Stage:
    """The stage that makes such content."""
    return next(stage for stage in STAGES.values() if stage.kind == type(content).__name__)


def _write(path: Path, content: object, config: Config) -> None:
    stage = _stage_of(content)
    made = Provenance(stage.name, f"rid.{stage.name.replace('-', '_')}", {}, {}, resolved(config))
    save_artifact(path, content, made, on_axis(linear=config.robot.linear))


def _configuration(result: Any) -> Config:
    """A configuration under which a result could have been made, as far as it is known."""
    if isinstance(result, Validation):
        best = result.models[result.best]
        roles = {name: r.role for name, r in best.records.items()}
        model = _model_of_structure(best.structure)
        used = [name for name, r in best.records.items() if r.used]
        return _configured(model, result.best, roles, used)
    fit, data = _basis(result)
    roles = {r.name: r.role for r in data} or dict.fromkeys(fit.records, "estimate")
    sources = {r.name: r.source for r in data.reports}
    return _configured(fit.model, fit.name, roles, list(fit.records), sources, fit.options)


def _basis(result: Fit | DiagnosedFit | ExtendedFit) -> tuple[Fit, Dataset]:
    """The fit that a result is of, and all records that it knows."""
    if isinstance(result, ExtendedFit):
        return result.origin, result.fit.dataset
    return (result.fit if isinstance(result, DiagnosedFit) else result), result.dataset


def _configured(
    model: Model,
    name: str,
    roles: Mapping[str, Any],
    used: Sequence[str],
    sources: Mapping[str, str] | None = None,
    options: Options | None = None,
) -> Config:
    roles = dict(roles) | dict.fromkeys(used, "estimate")
    records = [{"name": n, "role": role, "file": (sources or {}).get(n, n)} for n, role in roles.items()]
    options = options or Options()
    fit: dict[str, Any] = {"models": {name: list(used)}, "output": options.output, "horizon": options.horizon}
    flex = {"band": None if options.band is None else list(options.band), "window": options.window}
    rigid = {"cutoff": options.cutoff, "order": options.order, "min_speed": options.min_speed}
    return model.configuration(records, fit=fit, init_flex=flex, init_rigid=rigid)


def _model_of_structure(structure: Structure) -> Model:
    effects: dict[str, Any] = dict(effects_of(structure))
    changes = changes_of(structure)
    return Model(
        gear_ratio=structure.gear_ratio,
        linear=structure.linear,
        recorded_angle=structure.recorded_angle,
        changes=changes,
        **effects,
    )


def _artifact(path: Path, axis: str) -> Any:
    header = read_header(path, axis)
    name = header.provenance.stage
    if name not in STAGES:
        raise InputError(f'made by a stage "{name}" that this version does not know', where=str(path))
    config = parse(header.provenance.configuration)
    beside = _beside(path.parent, axis, but=name)
    return _assembled(path.parent, config, beside | {name: _content(path, STAGES[name], axis)})[name]


def _content(path: Path, stage: Stage, axis: str) -> Any:
    return load_artifact(path, stage.type(), axis).content


def _beside(folder: Path, axis: str, but: str = "") -> dict[str, Any]:
    """The contents of the artifacts in a folder, by stage; of another than `but`, what cannot be read is not there.
    axis : of a robot of several, which some artifacts may not have."""
    found = {}
    for stage in STAGES.values():
        file = folder / stage.output
        if stage.name != but and file.is_file():
            try:
                if axis in _axes(file):
                    found[stage.name] = _content(file, stage, axis)
            except InputError:
                if not but:
                    raise
    return found


def _artifacts(folder: Path) -> list[Path]:
    """The artifacts in a folder, in the order of their stages. Raises InputError where there is none."""
    files = [folder / stage.output for stage in STAGES.values() if (folder / stage.output).is_file()]
    if not files:
        raise InputError("this folder holds no artifact", where=str(folder), hint="give a run directory")
    return files


def _run(folder: Path, axis: str) -> RunContents:
    last = [file for file in _artifacts(folder) if axis in _axes(file)][-1]
    config = parse(read_header(last, axis).provenance.configuration)
    found = _assembled(folder, config, _beside(folder, axis))
    fits = found.get("fits", {})
    return RunContents(
        folder,
        config,
        model_of(config),
        found.get("collect", Dataset()),
        found.get("init-rigid"),
        found.get("init-flex"),
        fits,
        found.get("fit"),
        found.get("validate"),
        found.get("diagnose"),
        found.get("extend"),
    )


def _assembled(folder: Path, config: Config, contents: Mapping[str, Any]) -> dict[str, Any]:
    """Contents by stage as the front door has them: records as a dataset, and what rests on a fit with that fit."""
    found = dict(contents)
    recordings: Recordings = contents.get("collect", Recordings(()))
    data = Dataset(recordings.records, recordings.reports)
    if "collect" in found:
        found["collect"] = data
    if "fit" not in found:
        return found
    fits: Fits = contents["fit"]
    rigid, flex = contents.get("init-rigid"), contents.get("init-flex")
    every = {name: _fit(one, config, data, rigid, flex) for name, one in fits.models.items()}
    found |= {"fits": every, "fit": every[fits.best]}
    if (diagnosis := contents.get("diagnose")) is not None and diagnosis.model in every:
        of = every[diagnosis.model]
        found["diagnose"] = DiagnosedFit(**fields_of(diagnosis, Diagnosis), fit=of, dataset=data)
    if (extension := contents.get("extend")) is not None and extension.model in every:
        before = every[extension.model]
        after = extended_fit(before, extension.fit, data)
        found["extend"] = ExtendedFit(**(fields_of(extension, Extension) | {"fit": after}), origin=before)
    return found


def _fit(result: FitResult, config: Config, data: Dataset, rigid: RigidResult | None, flex: FlexResult | None) -> Fit:
    joint = assemble(result.structure, angle=result.keeps_angle)
    guesses = (rigid.guesses if rigid else {}) | (flex.guesses if flex else {})
    initial = starting_parameters(joint, config.robot.known(), guesses, config.fit.fix)
    model = model_of(config)
    undeclared = [effect for effect in result.structure.effects if effect not in model.structure.effects]
    return Fit(
        **fields_of(result, FitResult),
        model=model.with_effects(*undeclared) if undeclared else model,
        dataset=data,
        options=replace(options_of(config), output=result.output, horizon=config.fit.fixed_horizon or result.horizon),
        initial=initial,
        rigid=rigid,
        flex=flex,
    )


@shows(Setup)
class SetupView(View[Setup]):
    """The model of a configuration, and its records by name."""

    def line(self) -> str:
        return f"{self.content.loaded.path}, {', '.join(r.name for r in self.content.config.records)}"

    def tables(self) -> Sequence[Table]:
        rows = tuple(
            (r.name, r.role, r.use, " + ".join(r.files) or "virtual robot") for r in self.content.config.records
        )
        return (*_model_tables(self.content.model), Table("Records", ("record", "role", "use", "source"), rows))


@shows(RunContents)
class RunView(View[RunContents]):
    """What there is in a run directory."""

    def line(self) -> str:
        return f"{self.content.folder}, {', '.join(name for name, _ in _present(self.content))}"

    def tables(self) -> Sequence[Table]:
        rows = tuple((name, repr(one)) for name, one in _present(self.content))
        return (Table(f"Run {self.content.folder}", ("", ""), rows),)


def _present(run: RunContents) -> Iterable[tuple[str, Any]]:
    names = ("records", "rigid", "flex", "fit", "validation", "diagnosis", "extension")
    return [(name, one) for name in names if (one := getattr(run, name)) is not None]


def _model_tables(model: Model) -> Sequence[Table]:
    return view_of(model).tables()
