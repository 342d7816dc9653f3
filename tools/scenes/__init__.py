"""Test scenes of the set `natural`: spectral path tracing with Mitsuba 3, and their storage as components."""
