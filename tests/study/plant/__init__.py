"""A robot joint that shares no code with robotid: its own equations, integrator, controller. It hands over files."""
