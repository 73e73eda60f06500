"""Trials: hide, let the tool diagnose from the files alone, judge what it says."""
