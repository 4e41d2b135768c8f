"""Many runs of one case: parameter sweeps, accuracy against time."""
