"""robotid: from torque and motor-angle recordings of a robot joint to a validated physical model."""

__version__ = "0.1.0"
