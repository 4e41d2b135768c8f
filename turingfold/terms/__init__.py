"""Terms: everything that contributes potential energy."""
