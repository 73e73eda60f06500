"""The one table of stages."""

from __future__ import annotations

from robotid.pipeline.stage import Stage

EXCITE = Stage(
    "excite",
    "excitation.h5",
    "robotid.stages.excite:excite",
    "robotid.signals.reference:Excitation",
    sections=("robot", "records", "plant"),
)
COLLECT = Stage(
    "collect",
    "records.h5",
    "robotid.stages.collect:collect",
    "robotid.signals.quality:Recordings",
    inputs=("excite",),
    sections=("robot", "records", "plant"),
    files=True,
    logs=True,
)
INIT_RIGID = Stage(
    "init-rigid",
    "rigid.h5",
    "robotid.stages.init_rigid:init_rigid",
    "robotid.estimate.rigid:RigidResult",
    inputs=("collect",),
    sections=("robot", "init_rigid"),
)
INIT_FLEX = Stage(
    "init-flex",
    "flex.h5",
    "robotid.stages.init_flex:init_flex",
    "robotid.estimate.flexible:FlexResult",
    inputs=("collect", "init-rigid"),
    sections=("robot", "init_flex"),
)
FIT = Stage(
    "fit",
    "model.h5",
    "robotid.stages.fit:fit",
    "robotid.estimate.result:Fits",
    inputs=("collect", "init-rigid", "init-flex"),
    sections=("robot", "fit"),
    logs=True,
)
VALIDATE = Stage(
    "validate",
    "validation.h5",
    "robotid.stages.validate:validate",
    "robotid.validation.results:Validation",
    inputs=("collect", "init-rigid", "init-flex", "fit"),
    sections=("robot", "plant", "controller", "init_rigid", "fit", "validate"),
    logs=True,
)

DIAGNOSE = Stage(
    "diagnose",
    "diagnosis.h5",
    "robotid.stages.diagnose:diagnose",
    "robotid.diagnosis.results:Diagnosis",
    inputs=("collect", "fit"),
    sections=("robot", "plant", "controller", "fit", "diagnose"),
    logs=True,
)

EXTEND = Stage(
    "extend",
    "extension.h5",
    "robotid.stages.extend:extend",
    "robotid.extension.results:Extension",
    inputs=("collect", "fit", "diagnose"),
    sections=("robot", "fit", "extend"),
    logs=True,
    beside=("extended.yaml", "robotid.stages.extend:extended_configuration"),
)

STAGES: dict[str, Stage] = {
    s.name: s for s in (EXCITE, COLLECT, INIT_RIGID, INIT_FLEX, FIT, VALIDATE, DIAGNOSE, EXTEND)
}
"""Every stage by name, in order."""
