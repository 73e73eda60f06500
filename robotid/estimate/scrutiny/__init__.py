"""Whether a fit that ended well can be believed.

An error of the model goes into the parameters and the first states where these can imitate it: the least squares are
then found, and wrong. Such a fit moves away from what is known without it: the torque of the rigid motion, the inertia
of the start, the measured first speed. It is then tried again with a constant torque free, the commonest thing that a
model lacks and that makes an open simulation drift, or in pieces over which nothing adds up.

Reading order: task (what is fitted), doubts, instability, pieces, lacking, scrutinise (`scrutinised_fit`). `settings`
holds the tuning constants.
"""

from robotid.estimate.scrutiny.doubts import doubts
from robotid.estimate.scrutiny.scrutinise import scrutinised_fit
from robotid.estimate.scrutiny.task import FitTask, ScrutinisedFit

__all__ = ["FitTask", "ScrutinisedFit", "doubts", "scrutinised_fit"]
