"""The one table of stages: all that the rest of the program knows of a stage stands in its row."""

from __future__ import annotations

from robotid.pipeline.stage import Companion, Product, Stage

EXCITE = Stage(
    name="excite",
    summary="Reference signals for the records of the virtual robot.",
    heading="Excitation",
    output="excitation.h5",
    function="robotid.stages.excite:excite",
    content="robotid.signals.reference:Excitation",
    finding="excitation",
    shared="robotid.stages.excite:References",
    tables="robotid.report.tables.excite",
    sections=("robot", "records", "plant"),
)

COLLECT = Stage(
    name="collect",
    summary="Records from the virtual robot or from files, with their flaws.",
    heading="Records",
    output="records.h5",
    function="robotid.stages.collect:collect",
    content="robotid.signals.quality:Recordings",
    finding="recordings",
    shared="robotid.stages.collect:Common",
    tables="robotid.report.tables.collect",
    inputs=("excite",),
    for_virtual=("excite",),
    sections=("robot", "records", "plant"),
    reads_files=True,
    logs=True,
    export="robotid.pipeline.exports:signals",
)

INIT_RIGID = Stage(
    name="init-rigid",
    summary="Inertia and friction of the rigid joint, by least squares.",
    heading="First step: the rigid joint",
    output="rigid.h5",
    function="robotid.stages.init_rigid:init_rigid",
    content="robotid.estimate.rigid:RigidResult",
    finding="rigid",
    tables="robotid.report.tables.init_rigid",
    inputs=("collect",),
    sections=("robot", "init_rigid"),
)

INIT_FLEX = Stage(
    name="init-flex",
    summary="Arm inertia and stiffness, from frequency responses.",
    heading="Second step: what flexes",
    output="flex.h5",
    function="robotid.stages.init_flex:init_flex",
    content="robotid.estimate.flexible:FlexResult",
    finding="flex",
    tables="robotid.report.tables.init_flex",
    inputs=("collect", "init-rigid"),
    sections=("robot", "init_flex"),
    export="robotid.pipeline.exports:responses",
)

FIT = Stage(
    name="fit",
    summary="Every model over its records by simulation.",
    heading="Fit",
    output="model.h5",
    function="robotid.stages.fit:fit",
    content="robotid.estimate.result:Fits",
    finding="fits",
    tables="robotid.report.tables.fit",
    inputs=("collect", "init-rigid", "init-flex"),
    sections=("robot", "fit"),
    logs=True,
    export="robotid.pipeline.exports:model",
    after_run="latest",
)

VALIDATE = Stage(
    name="validate",
    summary="What the fitted models are worth, on every record.",
    heading="Validation",
    output="validation.h5",
    function="robotid.stages.validate:validate",
    content="robotid.validation.results:Validation",
    finding="validation",
    tables="robotid.report.tables.validate",
    inputs=("collect", "init-rigid", "init-flex", "fit"),
    sections=("robot", "plant", "controller", "init_rigid", "fit", "validate"),
    logs=True,
    after_run="latest",
)

DIAGNOSE = Stage(
    name="diagnose",
    summary="What the simulation gets wrong, and the physical cause.",
    heading="Diagnosis",
    output="diagnosis.h5",
    function="robotid.stages.diagnose:diagnose",
    content="robotid.diagnosis.results:Diagnosis",
    finding="diagnosis",
    tables="robotid.report.tables.diagnose",
    inputs=("collect", "fit"),
    sections=("robot", "plant", "controller", "fit", "diagnose"),
    logs=True,
    after_run="always",
)

EXTEND = Stage(
    name="extend",
    summary="The model with its causes, fitted anew, and the gain on records it did not see.",
    heading="Extension",
    output="extension.h5",
    function="robotid.stages.extend:extend",
    content="robotid.extension.results:Extension",
    finding="extension",
    tables="robotid.report.tables.extend",
    inputs=("collect", "fit", "diagnose"),
    sections=("robot", "fit", "extend"),
    logs=True,
    export="robotid.pipeline.exports:extended_model",
    after_run="always",
    companion=Companion("extended.yaml", "robotid.config.extended:extended_configuration"),
)

REPORT = Product(
    name="report",
    summary="One page of what the stages have found so far, and its figures.",
    heading="Report",
    output="report.html",
    tables="robotid.report.tables.report",
)
"""A view of the artifacts, not an artifact: it may be made after any stage."""

STAGES: dict[str, Stage] = {
    s.name: s for s in (EXCITE, COLLECT, INIT_RIGID, INIT_FLEX, FIT, VALIDATE, DIAGNOSE, EXTEND)
}
"""Every stage by name, in order."""

PRODUCTS: dict[str, Product] = {**STAGES, REPORT.name: REPORT}
"""Every stage, and the report after them."""
