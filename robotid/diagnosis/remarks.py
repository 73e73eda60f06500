"""What to know beside a verdict, in sentences."""

from __future__ import annotations

from robotid.diagnosis.results import Verdict
from robotid.diagnosis.search.state import SearchResult
from robotid.diagnosis.search.torque_errors import passing, torque_errors
from robotid.model.units import on_axis
from robotid.numerals import listed, plain

UNEXPLAINED = "the model does not simulate the records that it was fitted to: `robotid check` examines them"
SWAMPED = (
    "what the model leaves may be errors of the torque, but of {}, {} % of what was recorded: whatever is missing would"
    " not show; record a clearer torque, or a motion that is simulated better"
)
PASSES = (
    "what the model leaves passes for errors of the torque of {}, {} % of what was recorded: an effect that is smaller,"
    " or as slow as they are, would not show"
)
APART = (
    "no fit of the model simulates both the records of its fit and {}: more differs there than could be found, or"
    " something is missing that the former do not show; fit {}, too, to look for it"
)
JOINED = "the model simulates {} as well once it is fitted to them, too: the other records leave a parameter uncertain"
BESIDE = (
    "what is left is no effect: the parameters and gains of the causes are those beside it, and `extend`"
    " keeps these parameters, for a fit without the curve would lead them astray"
)
IMITATED = (
    "what is missing acts like {}, whose parameters make no sense here: either something else is missing, or the motion"
    " covers too little of it"
)
SHAKEN = (
    "what is missing rings like {} by itself: no motion of the joint drives it, so that something shakes the joint from"
    " outside, as another axis does"
)
SHAPELESS = (
    "the misfit is far above the noise, yet no curve along one variable both carries over and stands out of noise of"
    " any colour"
)


def remarks(word: Verdict, found: SearchResult, *, swamped: bool) -> tuple[str, ...]:
    """What to know beside a verdict. swamped : errors of the torque may hide what is missing."""
    if swamped:
        return (_sized(SWAMPED, found),)
    if word == "not explained":
        return (UNEXPLAINED,)
    joined, apart = listed(found.agreement.joined), listed(found.agreement.apart)
    if word == "unknown":
        if apart:
            return (APART.format(apart, apart),)
        if found.imitated:
            like = next(one for one in found.rejected if one.imitates)
            return ((SHAKEN if like.undriven else IMITATED).format(like.effect),)
        return (SHAPELESS,) if found.curve is None and not found.late else ()
    sentences = [BESIDE] if found.beside_curve else []
    if passing(found) > 0.0:
        sentences.append(_sized(PASSES, found))
    if word == "clean" and joined:
        sentences.append(JOINED.format(joined))
    return tuple(sentences)


def without_name(sentences: tuple[str, ...]) -> tuple[str, ...]:
    """The remarks of a diagnosis whose causes are none after all: what they left passed for errors of the torque."""
    passes = PASSES.partition("{")[0]
    return (*(one for one in sentences if not one.startswith(passes)), SHAPELESS)


def _sized(remark: str, found: SearchResult) -> str:
    """A remark with how large the errors of the torque are."""
    size, share = torque_errors(found)
    unit = on_axis(linear=found.last.structure.linear)("Nm")
    return remark.format(f"{plain(size, 2)} {unit}", plain(100.0 * share, 2))
