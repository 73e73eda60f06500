"""Measured frequency responses."""

from __future__ import annotations

import numpy as np

from robotid.export.write import Columns
from robotid.model.units import on_axis
from robotid.signals.frf import Frf


def response_columns(frf: Frf, *, linear: bool) -> Columns:
    """A response from motor torque to motor acceleration, a row a frequency. linear : of a sliding axis."""
    unit = on_axis(linear=linear)("rad/s2/Nm")
    optional = {"noise_std": frf.noise_std, "distortion_std": frf.distortion_std}
    return {
        "frequency [Hz]": frf.frequency,
        f"real [{unit}]": frf.response.real,
        f"imag [{unit}]": frf.response.imag,
        f"magnitude [{unit}]": np.abs(frf.response),
        "phase [rad]": np.unwrap(np.angle(frf.response)),
        f"std [{unit}]": frf.std,
        **{f"{name} [{unit}]": values for name, values in optional.items() if values is not None},
    }
