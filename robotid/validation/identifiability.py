"""What the records of a fit can tell of each parameter, and why not more."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robotid.estimate.result import Estimate, FitResult
from robotid.model.array import Array
from robotid.numerals import plain
from robotid.validation.results import Identifiability, Verdict
from robotid.validation.torque_share import TorqueShare

# Relative standard deviation: beyond a half the value is not distinct from zero.
UNSEEN_STD, WEAK_STD = 0.5, 0.1
# Share of the port's torque. The torque of a real joint is explained to a few percent at best, so what carries less
# than that is hidden by errors of the rest, whatever the noise.
UNSEEN_SHARE, WEAK_SHARE = 0.02, 0.05
# Multiple correlation with the other parameters: beyond, the standard deviation is twenty times what it would be alone.
WEAK_COSINE = 0.999


def identify(fit: FitResult, shares: Mapping[str, TorqueShare]) -> tuple[Identifiability, ...]:
    """Verdict on every parameter of a fit. shares : of the effects along the records of the fit."""
    cosines = column_cosines(fit.covariance)
    correlation = correlations(fit.covariance)
    return tuple(
        _judge(fit, k, p, shares.get(p.name.rpartition(".")[0]), cosines, correlation)
        for k, p in enumerate(fit.parameters)
    )


def hidden_by_errors(one: Identifiability) -> bool:
    """Whether a parameter that stands out of the noise is called unseen for its small torque, which errors of the rest
    would hide."""
    if one.verdict != "unseen" or one.relative_std is None or one.torque_share is None:
        return False
    return one.relative_std <= UNSEEN_STD and one.torque_share < UNSEEN_SHARE


def correlations(covariance: Array) -> Array:
    """Correlation matrix (p, p) of estimates; zero where a parameter was not estimated."""
    std = np.sqrt(np.diag(covariance))
    known = np.where(std > 0, std, 1.0)
    return np.asarray(covariance / np.outer(known, known))


def column_cosines(covariance: Array) -> Array:
    """Cosine of each parameter's Jacobian column with the span of the others, (p,).

    sqrt(1 - 1 / (C_kk (C^-1)_kk)) with C = (J^T J)^-1 up to a factor. Zero where a parameter was not estimated.
    """
    cosines = np.zeros(len(covariance))
    known = np.flatnonzero(np.diag(covariance) > 0)
    if len(known):
        inverse = np.linalg.pinv(correlations(covariance)[np.ix_(known, known)], hermitian=True)
        cosines[known] = np.sqrt(np.clip(1 - 1 / np.maximum(np.diag(inverse), 1.0), 0.0, 1.0))
    return cosines


def _judge(
    fit: FitResult, k: int, p: Estimate, share: TorqueShare | None, cosines: Array, correlation: Array
) -> Identifiability:
    carried = {} if share is None else {"torque_share": share.rms, "largest_share": share.largest}
    if p.fixed:
        return Identifiability(p.name, "fixed", "fixed at its value, not estimated", **carried)
    relative = p.std_robust / abs(p.value) if p.value else float("inf")
    reasons = [_by_std(p, relative), _by_share(share, relative), _by_cosine(fit, k, float(cosines[k]), correlation)]
    if p.remark.startswith("unidentifiable"):
        reasons.insert(0, ("unseen", p.remark))
    elif p.remark:
        reasons.insert(0, ("weak", p.remark))
    verdict: Verdict = next((v for v in ("unseen", "weak") if any(v == word for word, _ in reasons)), "seen")
    # A good parameter's reasons are all good; of another, those that made it so.
    why = "; ".join(text for word, text in reasons if text and (verdict == "seen" or word != "seen"))
    known = relative if np.isfinite(relative) else None
    return Identifiability(p.name, verdict, why, known, float(cosines[k]), **carried)


def _by_std(p: Estimate, relative: float) -> tuple[Verdict, str]:
    if relative > UNSEEN_STD:
        return "unseen", f"{plain(p.value)} +- {plain(p.std_robust, 2)} {p.unit} is not distinct from zero"
    text = f"standard deviation {plain(100 * relative, 2)} % of its value"
    return ("weak" if relative > WEAK_STD else "seen"), text


def _by_share(share: TorqueShare | None, relative: float) -> tuple[Verdict, str]:
    if share is None or share.alone:
        return "seen", ""
    text = f"{share.effect} carries {_percent(share.rms)} of the torque at the {share.port} (RMS)"
    if share.rms >= WEAK_SHARE:
        return "seen", text
    text += f", {_percent(share.largest)} where it is largest, at {share.there}" if share.there else ""
    if share.rms >= UNSEEN_SHARE:
        return "weak", text
    hidden = f"an error of {_percent(UNSEEN_SHARE)} anywhere else hides it"
    if relative <= UNSEEN_STD:
        hidden += f", though against noise alone its standard deviation is {plain(100 * relative, 2)} %"
    return "unseen", f"{text}: {hidden}"


def _by_cosine(fit: FitResult, k: int, cosine: float, correlation: Array) -> tuple[Verdict, str]:
    if cosine <= WEAK_COSINE:
        return "seen", ""
    others = np.abs(correlation[k]) * (np.arange(len(correlation)) != k)
    nearest = int(np.argmax(others))
    return "weak", (
        f"hardly distinguishable from the others (cosine {cosine:.4f}), least from {fit.parameters[nearest].name} "
        f"(correlation {correlation[k, nearest]:+.3f})"
    )


def _percent(share: float) -> str:
    return f"{plain(100 * share, 2)} %"
