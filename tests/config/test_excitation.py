import json

import pytest
from pydantic import TypeAdapter, ValidationError

from robotid.config.excitation import ExcitationSettings, ExperimentSettings, MultisinePart

ADAPTER: TypeAdapter[ExperimentSettings] = TypeAdapter(ExcitationSettings)
TRIANGLE = {"kind": "triangle", "amplitude": 40, "period": 5, "sampling_time": 0.0005}
MULTISINE = {"kind": "multisine", "band": [1, 40], "period": 5, "peak": 5, "sampling_time": 0.0005}
FALLING = {"kind": "multisine", "spectrum": [[1, 2], [40, 0.1]], "period": 5, "sampling_time": 0.0005}


def read(block: dict[str, object]) -> ExperimentSettings:
    return ADAPTER.validate_json(json.dumps(block), strict=True)


def sum_of(*parts: dict[str, object], **more: object) -> dict[str, object]:
    bare = [{k: v for k, v in part.items() if k != "sampling_time"} for part in parts]
    return {"kind": "sum", "of": bare, "sampling_time": 0.0005, **more}


@pytest.mark.parametrize(
    ("block", "samples"),
    [
        (TRIANGLE, 10_000),
        (TRIANGLE | {"duration": 6.25}, 12_500),
        (TRIANGLE | {"periods": 3}, 30_000),
        (sum_of(TRIANGLE, MULTISINE), 10_000),
        (sum_of(TRIANGLE | {"period": 2}, TRIANGLE | {"period": 3}), 12_000),
    ],
)
def test_length(block: dict[str, object], samples: int) -> None:
    assert read(block).samples == samples


def test_lines_are_the_multiples_within_the_band_edges_included() -> None:
    (part,) = read(MULTISINE).parts
    assert isinstance(part, MultisinePart)
    assert part.lines == range(5, 201)


def test_a_tables_band_is_its_range() -> None:
    (part,) = read(FALLING).parts
    assert isinstance(part, MultisinePart)
    assert part.edges == (1.0, 40.0)


@pytest.mark.parametrize("block", [TRIANGLE, MULTISINE, FALLING, sum_of(TRIANGLE, FALLING, periods=2)])
def test_round_trip(block: dict[str, object]) -> None:
    settings = read(block)
    assert ADAPTER.validate_json(ADAPTER.dump_json(settings), strict=True) == settings


@pytest.mark.parametrize(
    ("block", "message"),
    [
        (
            TRIANGLE | {"sampling_time": 0.0003},
            "the period 5 s is not a whole number of samples of 0.0003 s; 16667 samples are 5.0001 s",
        ),
        (
            TRIANGLE | {"duration": 1.0001},
            "the duration 1.0001 s is not a whole number of samples of 0.0005 s; 2000 samples are 1 s",
        ),
        (TRIANGLE | {"duration": 1e9}, "the duration 1e+09 s is more than 50,000,000 samples of 0.0005 s"),
        (TRIANGLE | {"periods": 9000}, "the reference would have 90,000,000 samples, at most 50,000,000 are made"),
        (TRIANGLE | {"periods": 2, "duration": 10}, "give duration or periods, not both"),
        (TRIANGLE | {"realisations": 2}, "only a multisine has realisations"),
        (
            TRIANGLE | {"kind": "square", "rise": 3},
            "a rise of 3 s does not fit into half the period of 5 s",
        ),
        (MULTISINE | {"band": None}, "a multisine with a flat spectrum needs band"),
        (MULTISINE | {"peak": None}, "a multisine with a flat spectrum needs peak"),
        (MULTISINE | {"band": [40, 1]}, "the band 40 to 1 Hz is empty"),
        (
            MULTISINE | {"band": [1, 4], "period": 0.1},
            "no multiple of 1 / period = 10 Hz lies in the band 1 to 4 Hz; lengthen the period",
        ),
        (
            MULTISINE | {"band": [1, 1000]},
            "the band ends at 1000 Hz, not below half the sampling frequency, 1000 Hz",
        ),
        (MULTISINE | {"duration": 2}, "2 s are shorter than the multisine's period of 5 s"),
        (sum_of(TRIANGLE, MULTISINE, duration=2), "2 s are shorter than the multisine's period of 5 s"),
        (FALLING | {"spectrum": [[2, 1], [1, 1]]}, "the frequencies of a spectrum must increase"),
        (FALLING | {"spectrum": [[1, 0], [2, 0]]}, "every amplitude of the spectrum is zero"),
        (FALLING | {"band": [0.5, 20]}, "the band must lie within the spectrum's 1 to 40 Hz"),
    ],
)
def test_refused(block: dict[str, object], message: str) -> None:
    with pytest.raises(ValidationError) as error:
        read(block)
    assert [detail["msg"] for detail in error.value.errors()] == [f"Value error, {message}"]


@pytest.mark.parametrize(
    ("block", "kind"),
    [
        (MULTISINE | {"spectrum": "flt"}, "literal_error"),
        (FALLING | {"spectrum": [[1, -2], [2, 1]]}, "greater_than_equal"),
        (FALLING | {"spectrum": [[1, 2]]}, "too_short"),
        (TRIANGLE | {"kind": "sine"}, "union_tag_invalid"),
        (TRIANGLE | {"amplitude": -1}, "greater_than"),
        (TRIANGLE | {"amplitud": 1}, "extra_forbidden"),
        (MULTISINE | {"crest_factor": 1}, "greater_than"),
    ],
)
def test_refused_by_type(block: dict[str, object], kind: str) -> None:
    with pytest.raises(ValidationError) as error:
        read(block)
    assert error.value.errors()[0]["type"] == kind
