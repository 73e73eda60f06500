"""robotid: from torque and motor-angle recordings of a robot joint to a validated physical model.

    import robotid as rid

    records = rid.read("log.csv", torque="torque", angle="angle [deg]")
    model = rid.Model(motor=["inertia", "viscous", "coulomb"])
    fit = rid.fit(model, records)
    found = rid.diagnose(fit, held_out=rid.read("day2.csv", torque="torque", angle="angle [deg]"))
    better = rid.extend(fit, found)

Every name is imported when it is first used, so that `import robotid` takes next to no time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from robotid.lazy import on_first_use

if TYPE_CHECKING:
    from robotid.config.schema import Config as Config
    from robotid.diagnosis.criteria import Criteria as Criteria
    from robotid.diagnosis.results import Cause as Cause
    from robotid.diagnosis.results import Diagnosis as Diagnosis
    from robotid.errors import RobotidError as RobotidError
    from robotid.estimate.result import FitResult as FitResult
    from robotid.extension.results import Extension as Extension
    from robotid.interface.checking import check as check
    from robotid.interface.control_design import state_space as state_space
    from robotid.interface.dataset import Dataset as Dataset
    from robotid.interface.evaluation import Simulation as Simulation
    from robotid.interface.evaluation import simulate as simulate
    from robotid.interface.evaluation import validate as validate
    from robotid.interface.explanation import explain as explain
    from robotid.interface.files import load as load
    from robotid.interface.files import save as save
    from robotid.interface.identification import Fit as Fit
    from robotid.interface.identification import Options as Options
    from robotid.interface.identification import fit as fit
    from robotid.interface.improvement import diagnose as diagnose
    from robotid.interface.improvement import extend as extend
    from robotid.interface.model import Model as Model
    from robotid.interface.monitoring import compare as compare
    from robotid.interface.monitoring import watch as watch
    from robotid.interface.reading import read as read
    from robotid.model.joint import Joint as Joint
    from robotid.model.parameters import KnownParameter as KnownParameter
    from robotid.model.parameters import Parameters as Parameters
    from robotid.model.structure import Structure as Structure
    from robotid.signals.columns import Column as Column
    from robotid.signals.plausibility.finding import Plausibility as Plausibility
    from robotid.signals.record import Record as Record
    from robotid.simulation.trajectory import Trajectory as Trajectory
    from robotid.validation.results import Validation as Validation

__version__ = "0.1.0"

_HOMES = {
    "read": "interface.reading",
    "check": "interface.checking",
    "Model": "interface.model",
    "fit": "interface.identification",
    "simulate": "interface.evaluation",
    "validate": "interface.evaluation",
    "diagnose": "interface.improvement",
    "extend": "interface.improvement",
    "compare": "interface.monitoring",
    "watch": "interface.monitoring",
    "state_space": "interface.control_design",
    "load": "interface.files",
    "save": "interface.files",
    "explain": "interface.explanation",
    "Column": "signals.columns",
    "Dataset": "interface.dataset",
    "Options": "interface.identification",
    "KnownParameter": "model.parameters",
    "Criteria": "diagnosis.criteria",
    "Fit": "interface.identification",
    "Simulation": "interface.evaluation",
    "Record": "signals.record",
    "Plausibility": "signals.plausibility.finding",
    "Structure": "model.structure",
    "Joint": "model.joint",
    "Parameters": "model.parameters",
    "Trajectory": "simulation.trajectory",
    "FitResult": "estimate.result",
    "Validation": "validation.results",
    "Diagnosis": "diagnosis.results",
    "Cause": "diagnosis.results",
    "Extension": "extension.results",
    "Config": "config.schema",
    "RobotidError": "errors",
}
"""Where each public name is, below this package."""

__all__ = ["__version__", *_HOMES]

__getattr__ = on_first_use(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(__all__)
