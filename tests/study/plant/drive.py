"""What lies between the recorded torque and the torque that acts, and between the motion and what is recorded of it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from math import cos, exp, pi, sin, tanh


@dataclass(frozen=True, slots=True)
class Drive:
    """Acting torque from the commanded one: lag(delay(saturation((1 + gain) u))).

    delay, lag [s]; most [Nm] : what a saturating drive tends to, zero for none. A delay counts in substeps.
    """

    gain: float = 0.0
    most: float = 0.0
    delay: float = 0.0
    lag: float = 0.0

    def started(self, dt: float, substeps: int) -> Callable[[float], list[float]]:
        """command -> torques in the substeps dt of the interval that it is held for. Rests at zero before."""
        late = [0.0] * round(self.delay / dt)
        left = exp(-dt / self.lag) if self.lag else 0.0
        mean = self.lag / dt * (1.0 - left)  # of what is left, over a substep
        lagged = 0.0

        def acting(command: float) -> list[float]:
            nonlocal late, lagged
            u = (1.0 + self.gain) * command
            if self.most:
                u = self.most * tanh(u / self.most)
            line = late + [u] * substeps
            torques, late = line[:substeps], line[substeps:]
            if self.lag:
                for k, target in enumerate(torques):
                    torques[k] = target + mean * (lagged - target)
                    lagged = target + left * (lagged - target)
            return torques

        return acting


@dataclass(frozen=True, slots=True)
class Sensor:
    """Encoder and speed as recorded, before noise.

    counts : of a turn; sine, cosine [rad] and periods : of the encoder's ripple; delay [s] : of the speed.
    """

    counts: int = 65536
    sine: float = 0.0
    cosine: float = 0.0
    periods: float = 0.0
    delay: float = 0.0

    def angle(self, phi_m: float) -> float:
        """Recorded angle [rad]."""
        turned = self.periods * phi_m
        step = 2.0 * pi / self.counts
        return step * round((phi_m + self.sine * sin(turned) + self.cosine * cos(turned)) / step)

    def speed(self, phi_m: float, dphi_m: float) -> float:
        """Time derivative of the angle that the encoder sees, without its steps [rad/s]."""
        turned, n = self.periods * phi_m, self.periods
        return dphi_m * (1.0 + n * (self.sine * cos(turned) - self.cosine * sin(turned)))

    def line(self, dt: float) -> deque[float]:
        """Speeds that are on their way, at rest; one a substep, and the present one."""
        return deque([0.0] * (round(self.delay / dt) + 1), maxlen=round(self.delay / dt) + 1)
